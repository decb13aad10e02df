// SPDX-License-Identifier: MIT
#include "hil/replay/depth_reader.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "hil/replay/depth_recording.h"

namespace pipewright::hil {
namespace {

static_assert(std::endian::native == std::endian::little);

bool MakesSense(std::uint32_t width, std::uint32_t height, const CameraIntrinsics& c) {
  bool finite = true;
  for (const double value : {c.fx, c.fy, c.cx, c.cy, c.z_min_m, c.z_max_m}) {
    finite = finite && std::isfinite(value);
  }
  return finite && width > 0 && height > 0 &&
         std::uint64_t{width} * height <= std::uint64_t{DepthFrame::kMaxPixels} && c.fx > 0 &&
         c.fy > 0;
}

}  // namespace

std::string DepthReader::Open(const std::string& path) {
  const std::string error = source_.Open(path);
  return error.empty() ? Begin(path) : fmt::format("{}: {}", path, error);
}

std::string DepthReader::Open(std::FILE* file, const std::string& name) {
  source_.Open(file);
  return Begin(name);
}

std::string DepthReader::Begin(const std::string& name) {
  if (TakeTag() && tag_ != kDepthCamera && tag_ != kDepthEnd) {
    return fmt::format("{}: is no depth recording: it begins with neither a camera nor an end",
                       name);
  }
  return "";
}

bool DepthReader::TakeBytes(std::span<char> to) {
  const std::size_t bytes = source_.Read(to);
  taken_ += bytes;
  return bytes == to.size();
}

template <typename T>
bool DepthReader::Take(T& value) {
  return TakeBytes({reinterpret_cast<char*>(&value), sizeof(T)});
}

void DepthReader::EndEarly(const std::string& why) {
  ended_ = true;
  broken_ = source_.error().empty() ? why : source_.error();
}

std::string DepthReader::end() const {
  return broken_.empty() ? "" : fmt::format("ends after {} frames: {}", frames_, broken_);
}

/// Looks at what is next. The item before has then been checked to its last byte.
bool DepthReader::TakeTag() {
  if (!Take(tag_)) {
    EndEarly("there is no end mark");
    return false;
  }
  return true;
}

bool DepthReader::TakeCamera() {
  CameraIntrinsics c;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  if (!Take(width) || !Take(height) || !Take(c.fx) || !Take(c.fy) || !Take(c.cx) || !Take(c.cy) ||
      !Take(c.z_min_m) || !Take(c.z_max_m) || !TakeTag()) {
    EndEarly("it breaks off within a camera's data");
    return false;
  }
  if (!MakesSense(width, height, c)) {
    EndEarly("a camera's data make no sense");
    return false;
  }
  c.width = static_cast<int>(width);
  c.height = static_cast<int>(height);
  camera_ = c;
  return true;
}

bool DepthReader::TakeDepths(DepthFrame& frame) {
  const std::size_t pixels =
      static_cast<std::size_t>(camera_->width) * static_cast<std::size_t>(camera_->height);
  folded_.resize(2 * pixels);
  if (!TakeBytes(folded_)) {
    return false;
  }
  std::uint16_t depth = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto low = static_cast<std::uint8_t>(folded_[i]);
    const auto high = static_cast<std::uint8_t>(folded_[pixels + i]);
    depth = static_cast<std::uint16_t>(depth + Unfold(static_cast<std::uint16_t>(high << 8 | low)));
    frame.depth_mm[i] = depth;
  }
  return true;
}

bool DepthReader::TakeFrame(DepthFrame& frame, Time& given) {
  std::int64_t given_ns = 0;
  std::int64_t stamp_ns = 0;
  if (!Take(frame.sequence) || !Take(given_ns) || !Take(stamp_ns) || !TakeDepths(frame)) {
    EndEarly("it breaks off within a frame");
    return false;
  }
  const std::uint64_t frame_end = taken_;
  if (!TakeTag() && source_.certain() < frame_end) {
    return false;  // its checksum is wrong or missing
  }
  frame.camera = *camera_;
  frame.stamp = Time(Duration(stamp_ns));
  given = Time(Duration(given_ns));
  ++frames_;
  return true;
}

void DepthReader::TakeEnd() {
  std::uint32_t frames = 0;
  if (!Take(frames) || frames != frames_) {
    EndEarly(fmt::format("its end mark counts {} frames", frames));
    return;
  }
  char more = 0;
  if (source_.Read({&more, 1}) > 0 || !source_.error().empty()) {
    EndEarly("something follows its end mark");
  }
  ended_ = true;
}

bool DepthReader::Next(DepthFrame& frame, Time& given) {
  while (!ended_) {
    switch (tag_) {
      case kDepthCamera:
        TakeCamera();
        break;
      case kDepthFrame:
        if (!camera_) {
          EndEarly("a frame before any camera");
          break;
        }
        if (TakeFrame(frame, given)) {
          return true;
        }
        break;
      case kDepthEnd:
        TakeEnd();
        break;
      default:
        EndEarly(fmt::format("no item is called 0x{:08X}", tag_));
    }
  }
  return false;
}

}  // namespace pipewright::hil
