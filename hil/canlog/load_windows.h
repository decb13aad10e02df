// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

/// What one channel carried in one window of time.
struct WindowLoad {
  std::int64_t begin_ns = 0;
  std::uint8_t channel = 0;
  std::uint64_t frames = 0;
  std::uint64_t bits = 0;  ///< of classic frames, stuff bits included
};

/// Cuts a log into windows of one length, from its first frame on, and tells of each window what
/// every channel carried in it, if anything. A frame belongs to the window in which its stamp lies;
/// one whose window has been told already, to the one that is open. Error messages and frames
/// without a time are left out.
class LoadWindows {
 public:
  using Report = std::function<void(const WindowLoad&)>;

  LoadWindows(std::int64_t window_ns, Report report)
      : window_ns_(window_ns), report_(std::move(report)) {}

  void Add(std::span<const LogFrame> frames);
  /// Tells of the last window.
  void End();

  std::uint64_t left_out() const { return left_out_; }  ///< CAN FD: in `frames`, not in `bits`

 private:
  void Tell();

  std::int64_t window_ns_;
  Report report_;
  bool open_ = false;
  std::int64_t begin_ns_ = 0;
  std::array<WindowLoad, 256> channels_{};
  std::uint64_t left_out_ = 0;
};

}  // namespace pipewright::hil
