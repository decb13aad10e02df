// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <queue>
#include <vector>

#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

/// Puts frames into the order of their times. A log of two channels is out of order by a few frames
/// where they were not read at once: a frame waits until kWaiting others have come. One that is
/// later than that comes out late.
class FrameSorter {
 public:
  static constexpr std::size_t kWaiting = 4096;

  /// Calls use(frame) with the frames that need wait no longer.
  template <typename Use>
  void Add(const LogFrame& frame, Use&& use) {
    waiting_.push({frame, count_++});
    if (waiting_.size() > kWaiting) {
      use(waiting_.top().frame);
      waiting_.pop();
    }
  }
  /// Likewise, with all that are left.
  template <typename Use>
  void End(Use&& use) {
    for (; !waiting_.empty(); waiting_.pop()) {
      use(waiting_.top().frame);
    }
  }

 private:
  struct Waiting {
    LogFrame frame;
    std::uint64_t number;

    /// By time; at one time, in the order of the log.
    bool operator<(const Waiting& other) const {
      return frame.stamp_ns != other.frame.stamp_ns ? frame.stamp_ns > other.frame.stamp_ns
                                                    : number > other.number;
    }
  };

  std::priority_queue<Waiting> waiting_;
  std::uint64_t count_ = 0;
};

}  // namespace pipewright::hil
