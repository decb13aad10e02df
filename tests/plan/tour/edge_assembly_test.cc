// SPDX-License-Identifier: MIT
#include "plan/tour/edge_assembly.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "tests/plan/tour/search_case.h"

namespace pipewright {
namespace {

using test::Costs;
using test::SearchCase;

const bool kSeeded = setenv("RC_PARAMS", "seed=20261124 max_success=300", 0) == 0;

std::vector<TourNode> NextOf(const std::vector<TourNode>& order) {
  std::vector<TourNode> next(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    next[order[k]] = order[(k + 1) % order.size()];
  }
  return next;
}

TEST(EdgeAssembly, MakesToursOfBothParentsWaysAndAFewOthers) {
  EXPECT_TRUE(kSeeded);
  EXPECT_TRUE(rc::check("children are tours", [] {
    const int n = *rc::gen::inRange(5, 60);
    const SearchCase c(n, *rc::gen::element(Costs::kAny, Costs::kUphill),
                       *rc::gen::arbitrary<unsigned>());
    const std::vector<TourNode> a = c.Shuffled(*rc::gen::arbitrary<unsigned>());
    const std::vector<TourNode> b = c.Shuffled(*rc::gen::arbitrary<unsigned>());
    const std::vector<TourNode> next_a = NextOf(a);
    const std::vector<TourNode> next_b = NextOf(b);
    EdgeAssembly assembly(n);
    const int cycles = assembly.Begin(a, b, c.costs);
    RC_ASSERT((cycles == 0) == (next_a == next_b));
    std::vector<TourNode> order(n);
    for (int k = 0; k < cycles; ++k) {
      if (!assembly.MakeChild(k, c.costs, c.neighbours)) {
        continue;
      }
      assembly.child().CopyOrder(order);
      RC_ASSERT(test::IsTour(c.tour.Problem(), order));
      const std::vector<TourNode> next = NextOf(order);
      for (TourNode x = 0; x < n; ++x) {
        RC_ASSERT(assembly.Differs(x) == (next[x] != next_a[x]));
        RC_ASSERT(assembly.child().cost_out()[x] == c.costs(x, next[x]));
      }
    }
  }));
}

TEST(EdgeAssembly, OfTwoToursThatDifferByOneExchangeTheChildIsTheOther) {
  const SearchCase c(12, Costs::kAny, 2);
  const std::vector<TourNode> a{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  const std::vector<TourNode> b{0, 1, 5, 6, 7, 2, 3, 4, 8, 9, 10, 11};
  EdgeAssembly assembly(12);
  ASSERT_EQ(assembly.Begin(a, b, c.costs), 1);
  ASSERT_TRUE(assembly.MakeChild(0, c.costs, c.neighbours));
  std::vector<TourNode> order(12);
  assembly.child().CopyOrder(order);
  EXPECT_EQ(order, b);
}

TEST(EdgeAssembly, OfSymmetricCostsAParentTheOtherWayRoundIsTheSame) {
  const SearchCase c(12, Costs::kPlane, 2);
  const std::vector<TourNode> a = c.Shuffled(1);
  std::vector<TourNode> b = a;
  std::reverse(b.begin(), b.end());
  EdgeAssembly assembly(12);
  EXPECT_EQ(assembly.Begin(a, b, c.costs), 0);
}

TEST(Subtours, AreJoinedWhereItCostsLeast) {
  // Two rings of three; by way of 2→3 and 5→0 joining costs least.
  test::TourCase tour{.n = 6, .costs = std::vector<float>(36, 50)};
  const auto set = [&](int i, int j, float cost) { tour.costs[i * 6 + j] = cost; };
  for (const int ring : {0, 3}) {
    for (int k = 0; k < 3; ++k) {
      set(ring + k, ring + (k + 1) % 3, 1);
    }
  }
  set(2, 3, 2);
  set(5, 0, 3);
  set(1, 4, 4);
  CostTable costs(6, 0);
  costs.Load(tour.Problem(), true);
  Neighbours neighbours(6);
  neighbours.Find(costs);
  Subtours subtours(6);
  const std::vector<TourNode> next{1, 2, 0, 4, 5, 3};
  const std::vector<TourNode> previous{2, 0, 1, 5, 3, 4};
  subtours.Assign(next, previous, std::vector<float>(6, 1));
  ASSERT_TRUE(subtours.Join(costs, neighbours));
  std::vector<TourNode> order(6);
  subtours.CopyOrder(order);
  EXPECT_EQ(order, (std::vector<TourNode>{0, 1, 2, 3, 4, 5}));
}

}  // namespace
}  // namespace pipewright
