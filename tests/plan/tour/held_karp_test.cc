// SPDX-License-Identifier: MIT
#include "plan/tour/held_karp.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/plan/tour/tour_cases.h"

namespace pipewright {
namespace {

using test::Costs;
using test::RandomTour;
using test::TourCase;

/// The order that HeldKarp finds, without the dummy.
std::vector<TourNode> Found(const TourCase& c) {
  CostTable table(c.n, HeldKarp::kNodesMax * HeldKarp::kNodesMax + HeldKarp::kFloats);
  table.Load(c.Problem(), false);
  std::vector<TourNode> order(table.size());
  HeldKarp::Solve(table, table.Spare(), order);
  if (c.open) {
    EXPECT_EQ(order.front(), table.dummy());
    order.erase(order.begin());
  }
  return order;
}

TEST(HeldKarp, FindsTheLeastOfAllPermutations) {
  for (int n = 2; n <= 8; ++n) {
    for (const Costs costs : {Costs::kAny, Costs::kSymmetric, Costs::kUphill}) {
      for (const bool open : {false, true}) {
        TourCase c = RandomTour(n, costs, static_cast<unsigned>(n));
        c.open = open;
        const std::vector<TourNode> order = Found(c);
        ASSERT_TRUE(test::IsTour(c.Problem(), order));
        EXPECT_NEAR(TourCost(c.Problem(), order), test::LeastOfAll(c.Problem()), 1e-5)
            << n << (open ? " open" : " closed");  // sums of float
      }
    }
  }
}

TEST(HeldKarp, KeepsTheEndsOfAnOpenTour) {
  for (int n = 2; n <= 7; ++n) {
    for (int entry = TourProblem::kFree; entry < n; ++entry) {
      for (int exit = TourProblem::kFree; exit < n; ++exit) {
        TourCase c = RandomTour(n, Costs::kAny, static_cast<unsigned>(n));
        c.open = true;
        c.entry = entry;
        c.exit = exit;
        if (CheckTour(c.Problem()) != Status::kOk) {
          continue;
        }
        const std::vector<TourNode> order = Found(c);
        ASSERT_TRUE(test::IsTour(c.Problem(), order)) << n << ' ' << entry << ' ' << exit;
        EXPECT_EQ(TourCost(c.Problem(), order), test::LeastOfAll(c.Problem()));
      }
    }
  }
}

TEST(HeldKarp, TakesAsManyNodesAsItSays) {
  // A ring whose ways of cost 1 are the only cheap ones.
  TourCase c = RandomTour(HeldKarp::kNodesMax, Costs::kAny, 5);
  for (float& cost : c.costs) {
    cost = 100;
  }
  for (int i = 0; i < c.n; ++i) {
    const int to = (i + 5) % c.n;
    c.costs[static_cast<std::size_t>(i) * c.n + to] = 1;
  }
  EXPECT_EQ(TourCost(c.Problem(), Found(c)), c.n);
}

}  // namespace
}  // namespace pipewright
