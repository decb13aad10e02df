// SPDX-License-Identifier: MIT
#include "tests/plan/tour/tour_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "platform/core/rng.h"

namespace pipewright::test {
namespace {

struct Point {
  double x;
  double y;
};

float Way(const Point& a, const Point& b, bool uphill) {
  const double climb = uphill ? std::max(0.0, b.y - a.y) : 0;
  return static_cast<float>(std::hypot(a.x - b.x, a.y - b.y) + climb);
}

}  // namespace

TourCase RandomTour(int n, Costs costs, std::uint64_t seed) {
  Rng rng(seed);
  TourCase c{.n = n};
  c.costs.assign(static_cast<std::size_t>(n) * n, std::numeric_limits<float>::quiet_NaN());
  std::vector<Point> points(n);
  for (Point& p : points) {
    p = {rng.Uniform(), rng.Uniform()};
  }
  const auto at = [&](int i, int j) -> float& {
    return c.costs[static_cast<std::size_t>(i) * n + j];
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      if (costs == Costs::kAny || costs == Costs::kSymmetric) {
        at(i, j) = static_cast<float>(rng.Index(60));
        at(j, i) = costs == Costs::kAny ? static_cast<float>(rng.Index(60)) : at(i, j);
      } else {
        at(i, j) = Way(points[i], points[j], costs == Costs::kUphill);
        at(j, i) = Way(points[j], points[i], costs == Costs::kUphill);
      }
    }
  }
  return c;
}

double LeastOfAll(const TourProblem& problem) {
  std::vector<TourNode> order(problem.n);
  std::iota(order.begin(), order.end(), TourNode{0});
  double least = std::numeric_limits<double>::infinity();
  do {
    if (IsTour(problem, order)) {
      least = std::min(least, TourCost(problem, order));
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return least;
}

bool IsTour(const TourProblem& problem, const std::vector<TourNode>& order) {
  std::vector<int> visits(problem.n);
  for (const TourNode a : order) {
    if (a < 0 || a >= problem.n) {
      return false;
    }
    ++visits[a];
  }
  return std::all_of(visits.begin(), visits.end(), [](int count) { return count == 1; }) &&
         (problem.entry == TourProblem::kFree || order.front() == problem.entry) &&
         (problem.exit == TourProblem::kFree || order.back() == problem.exit);
}

}  // namespace pipewright::test
