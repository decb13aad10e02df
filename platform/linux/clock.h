// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/core/time.h"

namespace pipewright {

/// CLOCK_MONOTONIC. The one place where the program learns what time it is.
Time Now();

/// Sleeps until `deadline` on that clock; signals do not wake it early.
void SleepUntil(Time deadline);

/// A grid of instants, one period apart.
///
///   PeriodicTimer tick(10ms);
///   while (!stop) Step(tick.Wait());
class PeriodicTimer {
 public:
  /// The first Wait() ends one period after `start`. period > 0.
  explicit PeriodicTimer(Duration period, Time start = Now());

  /// Sleeps until the next instant and returns the time then. When that instant is already past by
  /// a period or more, the instants in between are skipped and counted; the grid stays.
  Time Wait();

  std::uint64_t missed() const { return missed_; }
  /// Latest that Wait() has returned after its instant.
  Duration worst_latency() const { return worst_latency_; }

 private:
  Duration period_;
  Time next_;
  std::uint64_t missed_ = 0;
  Duration worst_latency_{};
};

}  // namespace pipewright
