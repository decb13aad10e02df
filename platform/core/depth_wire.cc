// SPDX-License-Identifier: MIT
#include "platform/core/depth_wire.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

namespace pipewright {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic = {'P', 'W', 'Z', '1'};

template <typename Unsigned>
void Put(Unsigned value, std::span<std::uint8_t> bytes, std::size_t at) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
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

std::size_t PutDepthFrame(const DepthFrame& frame, std::span<std::uint8_t> bytes) {
  const CameraIntrinsics& camera = frame.camera;
  const std::size_t size = kDepthHeadBytes + PixelBytes(frame);
  if (bytes.size() < size) {
    return 0;
  }
  std::copy(kMagic.begin(), kMagic.end(), bytes.begin());
  Put(frame.sequence, bytes, 4);
  Put(static_cast<std::uint64_t>(frame.stamp.time_since_epoch().count()), bytes, 8);
  Put(static_cast<std::uint32_t>(camera.width), bytes, 16);
  Put(static_cast<std::uint32_t>(camera.height), bytes, 20);
  std::size_t at = 24;
  for (const double value :
       {camera.fx, camera.fy, camera.cx, camera.cy, camera.z_min_m, camera.z_max_m}) {
    Put(std::bit_cast<std::uint64_t>(value), bytes, at);
    at += sizeof value;
  }
  for (std::size_t i = 0; i < PixelBytes(frame) / 2; ++i) {
    Put(frame.depth_mm[i], bytes, kDepthHeadBytes + 2 * i);
  }
  return size;
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

}  // namespace pipewright
