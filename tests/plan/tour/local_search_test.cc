// SPDX-License-Identifier: MIT
#include "plan/tour/local_search.h"

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

// rapidcheck reads its seed from the environment; unless someone sets another, it is this one.
const bool kSeeded = setenv("RC_PARAMS", "seed=20261124 max_success=300", 0) == 0;

TEST(LocalSearch, LeavesATourThatIsShorterByWhatItSays) {
  EXPECT_TRUE(kSeeded);
  EXPECT_TRUE(rc::check("gain = difference", [] {
    const int n = *rc::gen::inRange(5, 60);
    const Costs kind =
        *rc::gen::element(Costs::kAny, Costs::kSymmetric, Costs::kPlane, Costs::kUphill);
    const SearchCase c(n, kind, *rc::gen::arbitrary<unsigned>());
    ArrayTour tour(n);
    tour.Assign(c.Shuffled(*rc::gen::arbitrary<unsigned>()), c.costs);
    const double before = TourCost(c.tour.Problem(), tour.order());
    LocalSearch search(n);
    search.Begin(c.costs);
    for (const TourNode a : tour.order()) {
      search.Push(a);
    }
    TourClock clock({});
    const double gain = search.Descend(tour, c.costs, c.neighbours, clock);
    const std::vector<TourNode> order(tour.order().begin(), tour.order().end());
    RC_ASSERT(test::IsTour(c.tour.Problem(), order));
    RC_ASSERT(gain >= 0);
    RC_ASSERT(std::abs(before - gain - TourCost(c.tour.Problem(), order)) < 1e-3);
  }));
}

/// The most that exchanging any three ways, or turning any piece, gains.
double BestExchange(const SearchCase& c, const ArrayTour& tour) {
  const auto order = tour.order();
  const int n = tour.size();
  const auto way = [&](int i, int j) { return c.costs(order[i % n], order[j % n]); };
  double best = 0;
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      for (int d = b + 1; d < n; ++d) {
        best = std::max<double>(best, way(a, a + 1) + way(b, b + 1) + way(d, d + 1) -
                                          way(a, b + 1) - way(b, d + 1) - way(d, a + 1));
      }
      if (c.costs.symmetric()) {
        best =
            std::max<double>(best, way(a, a + 1) + way(b, b + 1) - way(a, b) - way(a + 1, b + 1));
      }
    }
  }
  return best;
}

TEST(LocalSearch, OfFewNodesLeavesNoExchangeThatGains) {
  // With so few nodes, the neighbour lists are complete.
  const int n = Neighbours::kMost + 1;
  for (const Costs kind : {Costs::kAny, Costs::kSymmetric, Costs::kPlane, Costs::kUphill}) {
    for (unsigned seed = 0; seed < 50; ++seed) {
      const SearchCase c(n, kind, seed);
      ArrayTour tour(n);
      tour.Assign(c.Shuffled(seed), c.costs);
      LocalSearch search(n);
      search.Begin(c.costs);
      TourClock clock({});
      for (int round = 0; round < 10; ++round) {  // not all who may move are queued again
        for (const TourNode a : tour.order()) {
          search.Push(a);
        }
        search.Descend(tour, c.costs, c.neighbours, clock);
      }
      EXPECT_LT(BestExchange(c, tour), 1e-5) << seed;
    }
  }
}

TEST(LocalSearch, StopsWhenItIsLate) {
  const SearchCase c(60, Costs::kUphill, 1);
  ArrayTour tour(60);
  tour.Assign(c.Shuffled(1), c.costs);
  LocalSearch search(60);
  search.Begin(c.costs);
  for (const TourNode a : tour.order()) {
    search.Push(a);
  }
  TourClock late({.now = [] { return Time::max(); }, .deadline = Time{}});
  EXPECT_EQ(search.Descend(tour, c.costs, c.neighbours, late), 0);
}

}  // namespace
}  // namespace pipewright
