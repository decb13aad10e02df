// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "platform/core/depth_frame.h"
#include "platform/core/depth_wire.h"
#include "platform/core/status.h"
#include "platform/core/time.h"

namespace pipewright {

/// The reading end of a depth stream: a Unix socket at which another process sends frames as
/// platform/core/depth_wire.h has them. Never waits; connects by itself, at most once a second, and
/// again when the other side has left or sends what is no frame. No heap after construction.
///
///   DepthSocket camera("/run/pipewright-camera/depth.sock");
///   if (camera.Poll(Now(), frame) == Status::kOk) ...
class DepthSocket {
 public:
  static constexpr Duration kRetry = std::chrono::seconds(1);

  explicit DepthSocket(std::string path) : path_(std::move(path)) {}
  ~DepthSocket() { Close(); }
  DepthSocket(const DepthSocket&) = delete;
  DepthSocket& operator=(const DepthSocket&) = delete;

  /// kTimeout: no whole frame yet; what has come of one is kept. kUnavailable: nobody is connected,
  /// error_text() says why. `frame` may be written in any case.
  Status Poll(Time now, DepthFrame& frame);
  std::string_view error_text() const { return error_; }

 private:
  void Close();
  Status Connect(Time now);
  Status Lost(const char* why);
  Status Fill(std::size_t size);

  std::string path_;
  int socket_ = -1;
  Time next_try_{};
  std::array<std::uint8_t, kDepthFrameMaxBytes> bytes_{};
  std::size_t have_ = 0;
  char error_[200] = "";
};

}  // namespace pipewright
