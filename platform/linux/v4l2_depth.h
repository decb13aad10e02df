// SPDX-License-Identifier: MIT
#pragma once

#include <linux/videodev2.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "platform/core/depth_frame.h"
#include "platform/core/status.h"
#include "platform/core/time.h"

namespace pipewright {

/// The calls that a camera takes, so that a test can stand in for a device. As ioctl(2), mmap(2).
class VideoCalls {
 public:
  virtual ~VideoCalls() = default;
  virtual int Open(const char* path);
  virtual void Close(int file);
  virtual int Ioctl(int file, unsigned long request, void* argument);
  virtual void* Map(int file, std::size_t bytes, std::int64_t offset);  ///< nullptr: refused
  virtual void Unmap(void* memory, std::size_t bytes);
};

/// A depth camera of the kernel (V4L2, single-planar capture, Z16: depth in millimetres), streaming
/// into mapped buffers. Never waits; opens by itself, at most once a second, and again after the
/// device has gone. No heap after construction.
///
///   V4l2Depth camera("/dev/video2", intrinsics, offset);
///   if (camera.Poll(Now(), frame) == Status::kOk) ...
class V4l2Depth {
 public:
  static constexpr Duration kRetry = std::chrono::seconds(1);
  static constexpr int kBuffers = 4;

  /// @param camera        width and height are asked for as they are; a device that gives others is
  ///                      refused
  /// @param stamp_offset  from the kernel's stamp to the middle of the exposure
  V4l2Depth(std::string path, const CameraIntrinsics& camera, Duration stamp_offset);
  V4l2Depth(std::string path, const CameraIntrinsics& camera, Duration stamp_offset,
            VideoCalls& calls);
  ~V4l2Depth() { Close(); }
  V4l2Depth(const V4l2Depth&) = delete;
  V4l2Depth& operator=(const V4l2Depth&) = delete;

  /// The newest frame that waits; older ones are passed over. kTimeout: none. kUnavailable: there
  /// is no such device, it is not a Z16 camera of this size, or it has gone: error_text() says
  /// which.
  Status Poll(Time now, DepthFrame& frame);
  std::string_view error_text() const { return error_; }
  /// Buffers that came with an error or too few bytes.
  std::uint64_t damaged() const { return damaged_; }

 private:
  struct Buffer {
    void* memory = nullptr;
    std::size_t bytes = 0;
  };

  void Close();
  Status Open(Time now);
  Status SetFormat();
  Status MapBuffers();
  Status Take(DepthFrame& frame, bool* taken);
  Status Fail(const char* what, int error = 0);
  int Call(unsigned long request, void* argument);
  v4l2_buffer Description(std::uint32_t index) const;

  std::string path_;
  CameraIntrinsics camera_;
  Duration stamp_offset_;
  VideoCalls own_calls_;
  VideoCalls& calls_;
  int file_ = -1;
  bool streaming_ = false;
  std::uint32_t line_bytes_ = 0;
  Time next_try_{};
  std::array<Buffer, kBuffers> buffers_;
  std::uint64_t damaged_ = 0;
  char error_[240] = "";
};

}  // namespace pipewright
