// SPDX-License-Identifier: MIT
#include "hil/canlog/load_windows.h"

#include "platform/can/bits.h"

namespace pipewright::hil {

void LoadWindows::Tell() {
  for (WindowLoad& load : channels_) {
    if (load.frames > 0) {
      load.begin_ns = begin_ns_;
      report_(load);
    }
    load.frames = 0;
    load.bits = 0;
  }
}

void LoadWindows::Add(std::span<const LogFrame> frames) {
  for (const LogFrame& frame : frames) {
    if (frame.error || !frame.stamped) {
      continue;
    }
    if (!open_) {
      open_ = true;
      begin_ns_ = frame.stamp_ns;
    }
    const std::int64_t since = frame.stamp_ns - begin_ns_;
    if (since >= window_ns_) {
      Tell();
      begin_ns_ += since / window_ns_ * window_ns_;
    }
    WindowLoad& load = channels_[frame.channel];
    load.channel = frame.channel;
    ++load.frames;
    if (frame.fd) {
      ++left_out_;
    } else {
      load.bits += static_cast<std::uint64_t>(can::FrameBits(ClassicFrame(frame)));
    }
  }
}

void LoadWindows::End() { Tell(); }

}  // namespace pipewright::hil
