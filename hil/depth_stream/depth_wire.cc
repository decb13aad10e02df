// SPDX-License-Identifier: MIT
#include "hil/depth_stream/depth_wire.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

namespace pipewright::hil {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic = {'P', 'W', 'Z', '1'};

template <typename Unsigned>
void Put(Unsigned value, std::vector<std::uint8_t>& bytes) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
}

template <typename Unsigned>
Unsigned Take(std::span<const std::uint8_t> bytes, std::size_t at) {
  Unsigned value = 0;
  for (std::size_t i = 0; i < sizeof value; ++i) {
    value = static_cast<Unsigned>(value | static_cast<Unsigned>(bytes[at + i]) << (8 * i));
  }
  return value;
}

bool Sound(std::uint64_t pixels, const CameraIntrinsics& camera) {
  const bool finite = std::isfinite(camera.fx) && std::isfinite(camera.fy) &&
                      std::isfinite(camera.cx) && std::isfinite(camera.cy) &&
                      std::isfinite(camera.z_min_m) && std::isfinite(camera.z_max_m);
  return finite && pixels > 0 && pixels <= DepthFrame::kMaxPixels && camera.fx > 0 &&
         camera.fy > 0 && camera.z_min_m >= 0 && camera.z_max_m > camera.z_min_m;
}

}  // namespace

void PutDepthFrame(const DepthFrame& frame, std::vector<std::uint8_t>& bytes) {
  const CameraIntrinsics& camera = frame.camera;
  bytes.assign(kMagic.begin(), kMagic.end());
  Put(frame.sequence, bytes);
  Put(static_cast<std::uint64_t>(frame.stamp.time_since_epoch().count()), bytes);
  Put(static_cast<std::uint32_t>(camera.width), bytes);
  Put(static_cast<std::uint32_t>(camera.height), bytes);
  for (const double value :
       {camera.fx, camera.fy, camera.cx, camera.cy, camera.z_min_m, camera.z_max_m}) {
    Put(std::bit_cast<std::uint64_t>(value), bytes);
  }
  assert(bytes.size() == kDepthHeadBytes);
  for (std::size_t i = 0; i < PixelBytes(frame) / 2; ++i) {
    Put(frame.depth_mm[i], bytes);
  }
}

Status TakeDepthHead(std::span<const std::uint8_t, kDepthHeadBytes> bytes, DepthFrame& frame) {
  const auto real = [&](std::size_t at) {
    return std::bit_cast<double>(Take<std::uint64_t>(bytes, at));
  };
  const auto width = Take<std::uint32_t>(bytes, 16);
  const auto height = Take<std::uint32_t>(bytes, 20);
  const CameraIntrinsics camera{.width = static_cast<int>(width),
                                .height = static_cast<int>(height),
                                .fx = real(24),
                                .fy = real(32),
                                .cx = real(40),
                                .cy = real(48),
                                .z_min_m = real(56),
                                .z_max_m = real(64)};
  if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin()) ||
      !Sound(std::uint64_t{width} * height, camera)) {
    return Status::kMalformed;
  }
  frame.sequence = Take<std::uint32_t>(bytes, 4);
  frame.stamp = Time{Duration{static_cast<std::int64_t>(Take<std::uint64_t>(bytes, 8))}};
  frame.camera = camera;
  return Status::kOk;
}

std::size_t PixelBytes(const DepthFrame& frame) {
  return 2 * static_cast<std::size_t>(frame.camera.width) *
         static_cast<std::size_t>(frame.camera.height);
}

void TakePixels(std::span<const std::uint8_t> bytes, DepthFrame& frame) {
  assert(bytes.size() == PixelBytes(frame));
  for (std::size_t i = 0; i < bytes.size() / 2; ++i) {
    frame.depth_mm[i] = Take<std::uint16_t>(bytes, 2 * i);
  }
}

}  // namespace pipewright::hil
