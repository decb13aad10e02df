// SPDX-License-Identifier: MIT
#include "platform/linux/clock.h"

#include <gtest/gtest.h>

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;

TEST(Clock, NeverGoesBack) {
  Time last = Now();
  for (int i = 0; i < 1000; ++i) {
    const Time now = Now();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(Clock, SleepsAtLeastUntilTheDeadline) {
  const Time deadline = Now() + 3ms;
  SleepUntil(deadline);
  EXPECT_GE(Now(), deadline);
  SleepUntil(Time{});  // long past: returns
  SleepUntil(Time(-1ms));
}

TEST(PeriodicTimer, NeverWakesBeforeItsInstant) {
  const Time start = Now();
  PeriodicTimer timer(2ms, start);
  for (int i = 1; i <= 5; ++i) {
    const Time woken = timer.Wait();
    EXPECT_GE(woken, start + i * 2ms);
  }
  EXPECT_GE(timer.worst_latency(), Duration::zero());
}

TEST(PeriodicTimer, SkipsAndCountsTheInstantsItHasMissed) {
  const Time start = Now() - 100ms;
  PeriodicTimer timer(10ms, start);
  const Time woken = timer.Wait();
  EXPECT_GE(timer.missed(), 9U);
  const auto instants = static_cast<std::int64_t>(timer.missed()) + 1;
  EXPECT_GE(woken, start + instants * 10ms);  // on the grid, not before
}

}  // namespace
}  // namespace pipewright
