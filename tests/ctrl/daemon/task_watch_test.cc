// SPDX-License-Identifier: MIT
#include "ctrl/daemon/task_watch.h"

#include <gtest/gtest.h>

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

constexpr TaskBounds kBounds{.control = 1s, .mapping = 2s, .planning = 30s};

TEST(TaskWatch, EachTaskHasItsOwnBound) {
  const struct {
    const char* name;
    TaskTurns turns;  ///< when the others turn and this one does not
    Duration bound;
  } cases[] = {
      {"control", {0, 1, 1}, 1s}, {"mapping", {1, 0, 1}, 2s}, {"planning", {1, 1, 0}, 30s}};
  for (const auto& c : cases) {
    TaskWatch watch(kBounds);
    watch.Start(Time{100s});
    TaskTurns turns;
    for (Time now{100s}; now <= Time{100s} + c.bound; now += 100ms) {
      turns.control += c.turns.control;
      turns.mapping += c.turns.mapping;
      turns.planning += c.turns.planning;
      watch.See(turns, now);
      EXPECT_EQ(watch.Silent(now), nullptr) << c.name;
    }
    const Time late = Time{100s} + c.bound + 1ms;
    EXPECT_STREQ(watch.Silent(late), c.name);
    EXPECT_FALSE(watch.MayStroke(late));
  }
}

TEST(TaskWatch, StrokesOnlyAfterControlAndMappingHaveTurnedSinceTheLastStroke) {
  TaskWatch watch(kBounds);
  watch.Start(Time{});
  EXPECT_FALSE(watch.MayStroke(Time{}));
  watch.See({1, 0, 0}, Time{1ms});
  EXPECT_FALSE(watch.MayStroke(Time{1ms}));
  watch.See({1, 1, 0}, Time{2ms});
  EXPECT_TRUE(watch.MayStroke(Time{2ms}));  // a long plan has its own bound
  watch.Stroked();
  EXPECT_FALSE(watch.MayStroke(Time{3ms}));
  watch.See({2, 1, 0}, Time{4ms});
  EXPECT_FALSE(watch.MayStroke(Time{4ms}));
  watch.See({2, 2, 0}, Time{5ms});
  EXPECT_TRUE(watch.MayStroke(Time{5ms}));
}

TEST(TaskWatch, StartForgetsTheRunBefore) {
  TaskWatch watch(kBounds);
  watch.Start(Time{});
  watch.See({5, 5, 5}, Time{1s});
  watch.Start(Time{100s});
  EXPECT_EQ(watch.Silent(Time{100s}), nullptr);
  EXPECT_FALSE(watch.MayStroke(Time{100s}));
}

}  // namespace
}  // namespace pipewright
