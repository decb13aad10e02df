// SPDX-License-Identifier: MIT
#include "plan/coverage/goal_ways.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace pipewright {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(GoalWays, BeginWithBoundsOfNothing) {
  const GoalWays ways(3, false);
  EXPECT_EQ(ways.Length(2, 1), 0);
  EXPECT_FALSE(ways.IsPlanned(2, 1));
  EXPECT_FALSE(ways.IsBlocked(2, 1));
}

TEST(GoalWays, AreWhatWasLastSaidOfThem) {
  GoalWays ways(9, false);
  EXPECT_EQ(ways.SetBound(7, 8, 2), Status::kOk);
  EXPECT_EQ(ways.Length(7, 8), 2);
  EXPECT_EQ(ways.SetReal(7, 8, {.length = 3, .handle = 42}), Status::kOk);
  EXPECT_TRUE(ways.IsPlanned(7, 8));
  EXPECT_FALSE(ways.IsBlocked(7, 8));
  EXPECT_EQ(ways.Length(7, 8), 3);
  EXPECT_EQ(ways.Handle(7, 8), 42);
  EXPECT_EQ(ways.Block(7, 8), Status::kOk);
  EXPECT_TRUE(ways.IsPlanned(7, 8));
  EXPECT_TRUE(ways.IsBlocked(7, 8));
  EXPECT_EQ(ways.Length(7, 8), kInfinity);
  EXPECT_EQ(ways.SetBound(7, 8, 1), Status::kOk);
  EXPECT_FALSE(ways.IsPlanned(7, 8));
  EXPECT_FALSE(ways.IsBlocked(7, 8));
  EXPECT_EQ(ways.Length(7, 8), 1);
}

TEST(GoalWays, AreTheSameBackWhereSymmetricAndNowhereElse) {
  for (const bool symmetric : {false, true}) {
    GoalWays ways(4, symmetric);
    EXPECT_EQ(ways.SetReal(3, 1, {.length = 5, .handle = 6}), Status::kOk);
    EXPECT_EQ(ways.IsPlanned(1, 3), symmetric);
    EXPECT_EQ(ways.Length(1, 3), symmetric ? 5 : 0);
    EXPECT_EQ(ways.Block(1, 2), Status::kOk);
    EXPECT_EQ(ways.IsBlocked(2, 1), symmetric);
    EXPECT_EQ(ways.SetBound(1, 3, 4), Status::kOk);
    EXPECT_EQ(ways.IsPlanned(3, 1), !symmetric);
  }
}

TEST(GoalWays, OfOneGoalAreSetBackAndNoOthers) {
  const std::vector<TourNode> all{0, 1, 2, 3};
  for (const bool symmetric : {false, true}) {
    GoalWays ways(4, symmetric);
    for (const int from : all) {
      for (const int to : all) {
        EXPECT_EQ(ways.SetReal(from, to, {.length = 9}),
                  from == to ? Status::kOutOfRange : Status::kOk);
      }
    }
    EXPECT_EQ(
        ways.SetBounds(2, all, [](int from, int to) { return static_cast<float>(10 * from + to); }),
        Status::kOk);
    for (const int from : all) {
      for (const int to : all) {
        if (from != to) {
          EXPECT_EQ(ways.IsPlanned(from, to), from != 2 && to != 2);
        }
      }
    }
    EXPECT_EQ(ways.Length(2, 3), 23);
    EXPECT_EQ(ways.Length(3, 2), symmetric ? 23 : 32);
  }
}

TEST(GoalWays, TakeNoLengthAndNoGoalBeyondTheirLimits) {
  GoalWays ways(3, false);
  for (const float length : {-1.0F, kNan, kInfinity, 2 * GoalWays::kLengthMax}) {
    EXPECT_EQ(ways.SetBound(0, 1, length), Status::kOutOfRange);
    EXPECT_EQ(ways.SetReal(0, 1, {.length = length}), Status::kOutOfRange);
    EXPECT_EQ(ways.SetBounds(0, std::vector<TourNode>{1}, [=](int, int) { return length; }),
              Status::kOutOfRange);
  }
  EXPECT_EQ(ways.SetBound(0, 1, GoalWays::kLengthMax), Status::kOk);
  EXPECT_FALSE(ways.IsBlocked(0, 1));
  for (const int goal : {-1, 1, 3}) {
    EXPECT_EQ(ways.SetBound(goal, 1, 0), Status::kOutOfRange);
    EXPECT_EQ(ways.SetReal(1, goal, {}), Status::kOutOfRange);
    EXPECT_EQ(ways.Block(goal, 1), Status::kOutOfRange);
  }
}

TEST(GoalWays, TakeNoMemoryButWhatTheySay) {
  EXPECT_EQ(GoalWays(512, true).MemoryBytes(), 512U * 512 * 8 + 512U * 512 / 8);
  EXPECT_EQ(GoalWays(0, true).MemoryBytes(), 0U);
}

}  // namespace
}  // namespace pipewright
