// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace pipewright {

/// The robot's monotonic clock. It has no now(): a step is handed its time.
struct RobotClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<RobotClock>;
  static constexpr bool is_steady = true;
};

using Duration = RobotClock::duration;
using Time = RobotClock::time_point;

constexpr double ToSeconds(Duration d) { return std::chrono::duration<double>(d).count(); }
constexpr double ToSeconds(Time t) { return ToSeconds(t.time_since_epoch()); }

/// Nearest nanosecond; |seconds| < 9e9.
constexpr Duration FromSeconds(double seconds) {
  return Duration{static_cast<Duration::rep>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5))};
}

}  // namespace pipewright
