// SPDX-License-Identifier: MIT
#include "plan/tour/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "tests/plan/tour/tour_cases.h"

namespace pipewright {
namespace {

using test::Costs;
using test::RandomTour;
using test::TourCase;

constexpr Costs kKinds[] = {Costs::kAny, Costs::kSymmetric, Costs::kPlane, Costs::kUphill};

/// The least cost of all permutations without fixed points.
double LeastAssignment(const TourProblem& p) {
  std::vector<TourNode> next(p.n);
  std::iota(next.begin(), next.end(), TourNode{0});
  double least = std::numeric_limits<double>::infinity();
  do {
    double cost = 0;
    for (int i = 0; i < p.n && cost < least; ++i) {
      cost = next[i] == i ? least : cost + p.Cost(i, next[i]);
    }
    least = std::min(least, cost);
  } while (std::next_permutation(next.begin(), next.end()));
  return least;
}

/// How far the duals overstep c(i, j) at most.
float Overstep(const CostTable& costs, const Assignment& assignment) {
  float most = -std::numeric_limits<float>::infinity();
  for (int i = 0; i < costs.size(); ++i) {
    for (int j = 0; j < costs.size(); ++j) {
      most = std::max(most, assignment.u()[i] + assignment.v()[j] - costs(i, j));
    }
  }
  return most;
}

TEST(Assignment, CostsAndBoundsWhatTheLeastOfAllPermutationsCosts) {
  for (int n = 2; n <= 8; ++n) {
    for (const Costs kind : kKinds) {
      for (unsigned seed = 0; seed < 10; ++seed) {
        const TourCase c = RandomTour(n, kind, seed);
        CostTable costs(n, 0);
        costs.Load(c.Problem(), true);
        Assignment assignment(n);
        TourClock clock({});
        assignment.Solve(costs, clock);
        EXPECT_NEAR(assignment.Bound(), LeastAssignment(c.Problem()), 1e-5) << n << ' ' << seed;
        EXPECT_LT(Overstep(costs, assignment), 1e-5F);
        std::vector<bool> reached(n);
        double cost = 0;
        for (int i = 0; i < n; ++i) {
          reached[assignment.next()[i]] = true;
          cost += costs(i, assignment.next()[i]);
        }
        EXPECT_EQ(std::count(reached.begin(), reached.end(), true), n);
        EXPECT_NEAR(cost, assignment.Bound(), 1e-5);
      }
    }
  }
}

TEST(Assignment, OfSymmetricCostsIsSymmetric) {
  const TourCase c = RandomTour(50, Costs::kPlane, 3);
  CostTable costs(c.n, 0);
  costs.Load(c.Problem(), true);
  Assignment assignment(c.n);
  TourClock clock({});
  assignment.Solve(costs, clock);
  EXPECT_TRUE(
      std::equal(assignment.u().begin(), assignment.u().begin() + c.n, assignment.v().begin()));
}

TEST(Assignment, CutShortStaysALowerBound) {
  const TourCase c = RandomTour(60, Costs::kUphill, 3);
  CostTable costs(c.n, 0);
  costs.Load(c.Problem(), true);
  Assignment assignment(c.n);
  TourClock enough({});
  assignment.Solve(costs, enough);
  const double best = assignment.Bound();
  TourClock late({.now = [] { return Time::max(); }, .deadline = Time{}});
  assignment.Solve(costs, late);
  EXPECT_LT(assignment.Bound(), best);
  EXPECT_TRUE(assignment.next().empty());
  EXPECT_LT(Overstep(costs, assignment), 1e-5F);
}

}  // namespace
}  // namespace pipewright
