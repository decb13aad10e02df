// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "hil/cli/run_figures.h"
#include "hil/devices/port.h"
#include "platform/can/bits.h"

namespace pipewright::hil {

/// A port whose stamps count from the run's start, and that counts.
class RunPort {
 public:
  RunPort(Port& port, const Time& epoch) : port_(port), epoch_(epoch) {}

  Status Send(const can::Frame& frame) {
    const Status status = port_.Send(frame);
    ++(status == Status::kOk ? tx_ : dropped_);
    return status;
  }
  bool Receive(can::Frame& frame) {
    if (!port_.Receive(frame)) {
      return false;
    }
    frame.stamp = Time{frame.stamp - epoch_};
    ++rx_;
    return true;
  }
  void AddTo(CanFigures& figures) const {
    figures.tx += tx_;
    figures.rx += rx_;
    figures.dropped += dropped_;
  }

 private:
  Port& port_;
  const Time& epoch_;
  std::uint64_t tx_ = 0;
  std::uint64_t rx_ = 0;
  std::uint64_t dropped_ = 0;
};

/// The busiest second of a wire, from the frames it carried.
class LoadMeter {
 public:
  explicit LoadMeter(int bitrate) : bitrate_(bitrate) {}

  void Add(const can::Frame& frame) {
    if (frame.stamp - second_ >= std::chrono::seconds(1)) {
      second_ = frame.stamp;
      last_ = bits_;
      bits_ = 0;
    }
    bits_ += frame.error ? 0 : can::FrameBits(frame);
    most_ = std::max(most_, bits_);
  }
  /// Of the last full second, 0 to 1.
  double Last() const { return static_cast<double>(last_) / bitrate_; }
  double Peak() const { return static_cast<double>(most_) / bitrate_; }

 private:
  int bitrate_;
  Time second_{};
  std::int64_t bits_ = 0;
  std::int64_t last_ = 0;
  std::int64_t most_ = 0;
};

}  // namespace pipewright::hil
