// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/canlog/byte_source.h"
#include "platform/core/depth_frame.h"

namespace pipewright::hil {

/// Reads a depth recording from front to back, in the memory of one frame. Every frame that it
/// gives is whole: its checksum was right.
///
///   DepthReader depth;
///   if (const std::string error = depth.Open(path); !error.empty()) return Fail(error);
///   while (depth.Next(frame, given)) Use(frame, given);
///   Tell(depth.end());
class DepthReader {
 public:
  /// @returns an error in words that names the path, or nothing
  std::string Open(const std::string& path);
  /// The same of a stream that is open for reading, which it takes over and calls `name`.
  std::string Open(std::FILE* file, const std::string& name);

  /// The next frame, and when the robot program got it. False: there is no more; `frame` may have
  /// changed.
  bool Next(DepthFrame& frame, Time& given);

  /// After the last frame: why the recording ends early, in words; empty if it does not.
  std::string end() const;
  std::uint32_t frames() const { return frames_; }  ///< read so far

 private:
  std::string Begin(const std::string& name);
  bool TakeTag();
  template <typename T>
  bool Take(T& value);
  bool TakeBytes(std::span<char> to);
  bool TakeCamera();
  bool TakeDepths(DepthFrame& frame);
  bool TakeFrame(DepthFrame& frame, Time& given);
  void TakeEnd();
  void EndEarly(const std::string& why);

  ByteSource source_;
  std::optional<CameraIntrinsics> camera_;
  std::vector<char> folded_;
  std::uint64_t taken_ = 0;  ///< bytes, unpacked
  std::uint32_t tag_ = 0;    ///< of the item that is next
  bool ended_ = false;
  std::string broken_;  ///< why it ends early
  std::uint32_t frames_ = 0;
};

}  // namespace pipewright::hil
