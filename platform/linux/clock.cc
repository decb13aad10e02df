// SPDX-License-Identifier: MIT
#include "platform/linux/clock.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <ctime>

namespace pipewright {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

}  // namespace

Time Now() {
  timespec ts{};
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return Time(Duration(ts.tv_sec * kNanosecondsPerSecond + ts.tv_nsec));
}

void SleepUntil(Time deadline) {
  const std::int64_t ns = deadline.time_since_epoch().count();
  if (ns <= 0) {
    return;
  }
  timespec ts{};
  ts.tv_sec = ns / kNanosecondsPerSecond;
  ts.tv_nsec = ns % kNanosecondsPerSecond;
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &ts, nullptr) == EINTR) {
  }
}

PeriodicTimer::PeriodicTimer(Duration period, Time start) : period_(period), next_(start + period) {
  assert(period > Duration::zero());
}

Time PeriodicTimer::Wait() {
  const Time before = Now();
  if (before - next_ >= period_) {
    const std::int64_t behind = (before - next_) / period_;
    missed_ += static_cast<std::uint64_t>(behind);
    next_ += behind * period_;
  }
  SleepUntil(next_);
  const Time now = Now();
  worst_latency_ = std::max(worst_latency_, now - next_);
  next_ += period_;
  return now;
}

}  // namespace pipewright
