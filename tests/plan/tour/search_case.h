// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "plan/tour/assignment.h"
#include "plan/tour/cost_table.h"
#include "plan/tour/neighbours.h"
#include "plan/tour/tour_clock.h"
#include "platform/core/rng.h"
#include "tests/plan/tour/tour_cases.h"

namespace pipewright::test {

/// A random problem with what a search makes of it first: reduced costs, and their neighbour lists.
struct SearchCase {
  SearchCase(int n, Costs kind, std::uint64_t seed)
      : tour(RandomTour(n, kind, seed)), costs(n, 0), neighbours(n) {
    Assignment assignment(n);
    TourClock clock({});
    costs.Load(tour.Problem(), true);
    assignment.Solve(costs, clock);
    costs.Reduce(assignment.u(), assignment.v());
    neighbours.Find(costs);
  }

  std::vector<TourNode> Shuffled(std::uint64_t seed) const {
    Rng rng(seed);
    std::vector<TourNode> order(tour.n);
    std::iota(order.begin(), order.end(), TourNode{0});
    for (int k = tour.n - 1; k > 0; --k) {
      std::swap(order[k], order[rng.Index(k + 1)]);
    }
    return order;
  }

  TourCase tour;
  CostTable costs;
  Neighbours neighbours;
};

}  // namespace pipewright::test
