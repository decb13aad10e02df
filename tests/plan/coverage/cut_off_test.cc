// SPDX-License-Identifier: MIT
#include "plan/coverage/cut_off.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "platform/core/rng.h"
#include "tests/plan/tour/tour_cases.h"

namespace pipewright {
namespace {

using test::TourCase;
using Nodes = std::vector<TourNode>;

constexpr float kBlocked = 1000;

Nodes CutOff(const TourCase& c) {
  Nodes found{99};
  FindCutOff(c.Problem(), kBlocked, found);
  return found;
}

/// Of these ways alone.
TourCase Only(int n, const std::vector<std::pair<int, int>>& ways, bool back) {
  TourCase c{.n = n, .costs = std::vector<float>(static_cast<std::size_t>(n) * n, kBlocked)};
  for (const auto& [from, to] : ways) {
    c.costs[static_cast<std::size_t>(from) * n + to] = 1;
    c.costs[static_cast<std::size_t>(to) * n + from] = back ? 1 : kBlocked;
  }
  return c;
}

TEST(FindCutOff, TellsNoNodeOfARing) {
  for (const bool back : {false, true}) {
    EXPECT_EQ(CutOff(Only(4, {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, back)), Nodes{});
  }
}

TEST(FindCutOff, TellsADeadEndUnlessATourMayEndThere) {
  TourCase c = Only(5, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}}, true);
  EXPECT_EQ(CutOff(c), Nodes{4});
  c.open = true;
  EXPECT_EQ(CutOff(c), Nodes{});
  c.entry = 1;
  EXPECT_EQ(CutOff(c), Nodes{});
  c.exit = 2;
  EXPECT_EQ(CutOff(c), Nodes{4});
  c.exit = 4;
  EXPECT_EQ(CutOff(c), Nodes{});
}

TEST(FindCutOff, TellsAllThatWouldHaveToBeginOneTour) {
  TourCase c = Only(4, {{0, 2}, {1, 2}, {2, 3}}, false);
  c.open = true;
  EXPECT_EQ(CutOff(c), (Nodes{0, 1}));
  c.entry = 0;
  EXPECT_EQ(CutOff(c), Nodes{1});
}

TEST(FindCutOff, DoesNotCountWaysBesideTheEnds) {
  TourCase c = Only(3, {{0, 1}, {1, 0}, {2, 1}}, false);  // entry 0 to exit 1, with 2 between
  c.open = true;
  c.entry = 0;
  c.exit = 1;
  EXPECT_EQ(CutOff(c), (Nodes{0, 2}));
}

TEST(FindCutOff, NeverTellsWhereThereIsATour) {
  int told = 0;
  int missed = 0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    Rng rng(seed);
    TourCase c{.n = 2 + rng.Index(5), .open = rng.Index(3) > 0};
    const int percent = rng.Index(80);
    for (int k = 0; k < c.n * c.n; ++k) {
      c.costs.push_back(rng.Index(100) < percent ? kBlocked : 1);
    }
    if (c.open) {
      c.entry = rng.Index(2) == 0 ? 0 : TourProblem::kFree;
      c.exit = rng.Index(2) == 0 ? 1 : TourProblem::kFree;
    }
    const bool none = test::LeastOfAll(c.Problem()) >= kBlocked;
    const bool found = !CutOff(c).empty();
    ASSERT_TRUE(none || !found) << "seed " << seed;
    told += found;
    missed += none && !found;
  }
  EXPECT_GT(told, 500);
  EXPECT_LT(missed, told);
}

}  // namespace
}  // namespace pipewright
