// SPDX-License-Identifier: MIT
#include "plan/tour/tour_solver.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "tests/plan/tour/tour_cases.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using test::Costs;
using test::IsTour;
using test::RandomTour;
using test::TourCase;

const bool kSeeded = setenv("RC_PARAMS", "seed=20261124 max_success=150", 0) == 0;

constexpr Costs kKinds[] = {Costs::kAny, Costs::kSymmetric, Costs::kPlane, Costs::kUphill};

class TourSolverTest : public testing::Test {
 protected:
  static constexpr int kRoom = 64;

  /// The figures, after the tour in order_ was found to be one, and to cost what they say.
  TourFigures Solved(const TourCase& c, std::int64_t trials = 400, std::uint64_t seed = 1) {
    order_.assign(c.n, -1);
    const auto figures = solver_.Solve(c.Problem(), {.trials = trials}, seed, order_);
    EXPECT_TRUE(figures.ok());
    if (!figures.ok()) {
      return {};
    }
    EXPECT_TRUE(IsTour(c.Problem(), order_));
    EXPECT_EQ(figures->cost, TourCost(c.Problem(), order_));
    EXPECT_LE(figures->bound, figures->cost);
    EXPECT_LE(figures->trials, trials);
    EXPECT_LE(figures->best_trial, figures->trials);
    return *figures;
  }

  Status Refused(const TourCase& c, int places) {
    order_.assign(places, -1);
    const auto figures = solver_.Solve(c.Problem(), {}, 1, order_);
    EXPECT_FALSE(figures.ok());
    EXPECT_TRUE(std::all_of(order_.begin(), order_.end(), [](TourNode a) { return a == -1; }));
    return figures.status();
  }

  TourSolver solver_{kRoom};
  std::vector<TourNode> order_;
};

TEST_F(TourSolverTest, OfOneNodeOrTwoThereIsOneTour) {
  EXPECT_EQ(Solved(RandomTour(1, Costs::kAny, 1)).cost, 0);
  TourCase two = RandomTour(2, Costs::kAny, 1);
  EXPECT_EQ(Solved(two).cost, two.costs[1] + two.costs[2]);
  two.open = true;
  EXPECT_EQ(Solved(two).cost, std::min(two.costs[1], two.costs[2]));
  two.exit = 0;
  EXPECT_EQ(Solved(two).cost, two.costs[2]);
  EXPECT_EQ(order_, (std::vector<TourNode>{1, 0}));
}

TEST_F(TourSolverTest, OfFewNodesItIsTheBest) {
  for (const Costs kind : kKinds) {
    for (const bool open : {false, true}) {
      TourCase c = RandomTour(8, kind, 3);
      c.open = open;
      const TourFigures figures = Solved(c);
      EXPECT_NEAR(figures.cost, test::LeastOfAll(c.Problem()), 1e-5);
      EXPECT_EQ(figures.bound, figures.cost);
    }
  }
}

TEST_F(TourSolverTest, GivesATourThatKeepsItsEnds) {
  EXPECT_TRUE(kSeeded);
  EXPECT_TRUE(rc::check("tours with their ends", [this] {
    const int n = *rc::gen::inRange(1, kRoom + 1);
    TourCase c = RandomTour(n, *rc::gen::elementOf(std::vector(kKinds, std::end(kKinds))),
                            *rc::gen::arbitrary<unsigned>());
    c.open = *rc::gen::arbitrary<bool>();
    if (c.open) {
      c.entry = *rc::gen::inRange(TourProblem::kFree, n);
      c.exit = *rc::gen::inRange(TourProblem::kFree, n);
    }
    RC_PRE(CheckTour(c.Problem()) == Status::kOk);
    Solved(c, *rc::gen::inRange(1, 200), *rc::gen::arbitrary<unsigned>());
    RC_ASSERT(!HasFailure());
  }));
}

TEST_F(TourSolverTest, NeverGetsWorseByTryingMore) {
  for (const Costs kind : kKinds) {
    TourCase c = RandomTour(40, kind, 7);
    double cost = std::numeric_limits<double>::infinity();
    for (const int trials : {1, 2, 10, 100, 1000}) {
      const double longer = Solved(c, trials).cost;
      EXPECT_LE(longer, cost * (1 + 1e-6));  // searched in float
      cost = longer;
    }
  }
}

TEST_F(TourSolverTest, IsTheSameForTheSameSeedAndTrials) {
  const TourCase c = RandomTour(60, Costs::kUphill, 2);
  const TourFigures first = Solved(c, 150, 5);
  const std::vector<TourNode> order = order_;
  Solved(RandomTour(30, Costs::kAny, 9), 77, 6);  // what was before does not matter
  const TourFigures second = Solved(c, 150, 5);
  EXPECT_EQ(order_, order);
  EXPECT_EQ(second.trials, first.trials);
  EXPECT_EQ(second.best_trial, first.best_trial);
  Solved(c, static_cast<int>(first.best_trial), 5);
  EXPECT_EQ(order_, order) << "best_trial found it";
}

TEST_F(TourSolverTest, AnOpenTourIsAClosedOneOverANodeThatCostsNothing) {
  for (const Costs kind : kKinds) {
    TourCase open = RandomTour(20, kind, 4);
    TourCase closed{.n = 21, .costs = std::vector<float>(21 * 21, 0)};
    for (int i = 0; i < 20; ++i) {
      std::copy_n(&open.costs[i * 20], 20, &closed.costs[i * 21]);
    }
    open.open = true;
    EXPECT_NEAR(Solved(open, 2000).cost, Solved(closed, 2000).cost, 1e-5);
  }
}

TEST_F(TourSolverTest, APathBetweenTwoNodesIsAClosedTourWhereTheyAreOne) {
  for (const Costs kind : kKinds) {
    TourCase path = RandomTour(20, kind, 5);
    path.open = true;
    path.entry = 19;
    path.exit = 18;
    TourCase closed{.n = 19, .costs = std::vector<float>(19 * 19)};  // leaves 18 as it left 19
    for (int i = 0; i < 19; ++i) {
      std::copy_n(&path.costs[(i == 18 ? 19 : i) * 20], 19, &closed.costs[i * 19]);
    }
    EXPECT_NEAR(Solved(path, 3000).cost, Solved(closed, 3000).cost, 1e-5);
  }
}

TEST_F(TourSolverTest, WithItsEndsGivenIsTheBestOverTheOthers) {
  // Where ends are dear to reach, free ends would be elsewhere; all but them lie on a line.
  TourCase c = RandomTour(30, Costs::kAny, 1);
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < 30; ++j) {
      const int apart = std::abs(i - j);
      c.costs[i * 30 + j] = static_cast<float>(apart);
    }
  }
  c.open = true;
  EXPECT_EQ(Solved(c, 1000).cost, 29);
  c.entry = 10;  // down to 0, then up to 29
  EXPECT_EQ(Solved(c, 1000).cost, 10 + 29);
  c.exit = 20;  // and back from 29 over what was left out: 9 of the way twice more
  EXPECT_EQ(Solved(c, 1000).cost, 10 + 29 + 9);
  c.entry = TourProblem::kFree;
  EXPECT_EQ(Solved(c, 1000).cost, 29 + 9);
}

TEST_F(TourSolverTest, OfSymmetricCostsTheOtherWayRoundCostsTheSame) {
  const TourCase c = RandomTour(40, Costs::kSymmetric, 8);
  const TourFigures figures = Solved(c);
  std::reverse(order_.begin(), order_.end());
  EXPECT_EQ(TourCost(c.Problem(), order_), figures.cost);
}

TEST_F(TourSolverTest, AvoidsWaysThatMustNotBeTaken) {
  TourCase c = RandomTour(40, Costs::kUphill, 8);
  Rng rng(1);
  for (float& cost : c.costs) {
    cost = rng.Uniform() < 0.5 ? 1e8F : cost;
  }
  EXPECT_LT(Solved(c, 1000).cost, 40);
}

TEST_F(TourSolverTest, StopsAtItsBound) {
  TourCase c = RandomTour(30, Costs::kAny, 8);
  std::fill(c.costs.begin(), c.costs.end(), 3.0F);  // all tours are the best
  const TourFigures figures = Solved(c);
  EXPECT_EQ(figures.cost, 90);
  EXPECT_NEAR(figures.bound, 90, 1e-5);
  EXPECT_EQ(figures.trials, 1);
}

TEST_F(TourSolverTest, AtADeadlineThatIsPastStillGivesATour) {
  const TourCase c = RandomTour(60, Costs::kUphill, 3);
  order_.assign(c.n, -1);
  const TourBudget late{.now = [] { return Time::max(); }, .deadline = Time{}};
  const auto figures = solver_.Solve(c.Problem(), late, 1, order_);
  ASSERT_TRUE(figures.ok());
  EXPECT_TRUE(IsTour(c.Problem(), order_));
  EXPECT_EQ(figures->trials, 1);
}

TEST_F(TourSolverTest, EndsAtItsDeadline) {
  static int readings;
  readings = 0;
  const TourCase c = RandomTour(60, Costs::kUphill, 3);
  order_.assign(c.n, -1);
  const TourBudget budget{.trials = std::numeric_limits<std::int64_t>::max(),
                          .now = [] { return Time{Duration{++readings}}; },
                          .deadline = Time{Duration{200}}};
  const auto figures = solver_.Solve(c.Problem(), budget, 1, order_);
  ASSERT_TRUE(figures.ok());
  EXPECT_EQ(readings, 200);
  EXPECT_GT(figures->trials, 10);
  EXPECT_TRUE(IsTour(c.Problem(), order_));
}

TEST_F(TourSolverTest, TakesNothingFromTheHeap) {
  const TourCase large = RandomTour(kRoom, Costs::kUphill, 3);
  const TourCase small = RandomTour(9, Costs::kPlane, 3);
  std::vector<TourNode> of_large(large.n);
  std::vector<TourNode> of_small(small.n);
  const test::NoAllocScope no_alloc;
  EXPECT_TRUE(solver_.Solve(large.Problem(), {.trials = 300}, 1, of_large).ok());
  EXPECT_TRUE(solver_.Solve(small.Problem(), {.trials = 300}, 1, of_small).ok());
}

TEST_F(TourSolverTest, RefusesWhatItHasNoRoomFor) {
  EXPECT_EQ(Refused(RandomTour(kRoom + 1, Costs::kAny, 1), kRoom + 1), Status::kFull);
  TourCase open = RandomTour(kRoom, Costs::kAny, 1);
  open.open = true;  // the dummy does not count
  EXPECT_LT(0, Solved(open, 10).cost);
}

TEST_F(TourSolverTest, RefusesBadInput) {
  EXPECT_EQ(Refused({}, 0), Status::kOutOfRange);
  EXPECT_EQ(Refused(RandomTour(5, Costs::kAny, 1), 4), Status::kMalformed);
  EXPECT_EQ(Refused(RandomTour(5, Costs::kAny, 1), 6), Status::kMalformed);
  TourCase c = RandomTour(20, Costs::kAny, 1);
  c.costs[3] = std::nanf("");
  EXPECT_EQ(Refused(c, 20), Status::kOutOfRange);
  c.costs[3] = -1;
  EXPECT_EQ(Refused(c, 20), Status::kOutOfRange);
  c = RandomTour(20, Costs::kAny, 1);
  c.open = true;
  c.entry = c.exit = 3;
  EXPECT_EQ(Refused(c, 20), Status::kInfeasible);
}

TEST(TourSolver, For512NodesTakes1100KibibytesAtMost) {
  EXPECT_LE(TourSolver(512).MemoryBytes(), 1.1 * 1024 * 1024);
}

}  // namespace
}  // namespace pipewright
