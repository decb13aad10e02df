// SPDX-License-Identifier: MIT
#include "plan/coverage/multi_goal.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "tests/plan/coverage/way_cases.h"

namespace pipewright {
namespace {

using test::CaseWays;
using test::Climb;
using test::PlaneWays;
using test::RandomWays;
using test::TourCase;
using test::WayCase;
using Order = std::vector<TourNode>;

struct Ends {
  bool open = false;
  int entry = TourProblem::kFree;
  int exit = TourProblem::kFree;
};

constexpr Climb kClimbs[] = {Climb::kNone, Climb::kKnown, Climb::kUnknown};

constexpr Ends kAllEnds[] = {{},
                             {.open = true},
                             {.open = true, .entry = 1},
                             {.open = true, .exit = 0},
                             {.open = true, .entry = 2, .exit = 1}};

TourCase RealTour(const WayCase& c, const Ends& ends) {
  TourCase tour = c.RealTour();
  tour.open = ends.open;
  tour.entry = ends.entry;
  tour.exit = ends.exit;
  return tour;
}

class MultiGoalTest : public testing::Test {
 protected:
  /// Of one MultiGoal for all, so that none may depend on the one before.
  Status Plan(const WayCase& c, const Ends& ends, GoalWays& ways, CaseWays& planner) {
    const Order goals = c.Goals();
    const Status status =
        plan_.Solve({.goals = goals, .open = ends.open, .entry = ends.entry, .exit = ends.exit}, {},
                    1, ways, planner);
    order_ = {plan_.order().begin(), plan_.order().end()};
    EXPECT_EQ(plan_.queries(), planner.count() - counted_);
    counted_ = planner.count();
    return status;
  }
  Status Plan(const WayCase& c, const Ends& ends) {
    GoalWays ways = c.Ways();
    CaseWays planner(c);
    counted_ = 0;
    const Status status = Plan(c, ends, ways, planner);
    if (status == Status::kOk) {
      ExpectReal(c, ends, ways);
    }
    return status;
  }

  void ExpectReal(const WayCase& c, const Ends& ends, const GoalWays& ways) {
    const TourCase tour = RealTour(c, ends);
    ASSERT_TRUE(test::IsTour(tour.Problem(), order_));
    EXPECT_DOUBLE_EQ(plan_.length(), TourCost(tour.Problem(), order_));
    EXPECT_LE(plan_.bound(), plan_.length());
    EXPECT_TRUE(plan_.unreached().empty());
    const std::size_t count = ends.open ? order_.size() - 1 : order_.size();
    for (std::size_t k = 0; k < count; ++k) {
      const int from = order_[k];
      const int to = order_[(k + 1) % order_.size()];
      ASSERT_TRUE(ways.IsPlanned(from, to));
      ASSERT_FALSE(ways.IsBlocked(from, to));
      const bool turned = ways.symmetric() && from > to;
      EXPECT_EQ(ways.Handle(from, to), turned ? to * c.n + from : from * c.n + to);
    }
  }

  MultiGoal plan_{120};
  Order order_;
  int counted_ = 0;
};

TEST_F(MultiGoalTest, IsTheBestOfAllPermutationsRoundObstacles) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const int n = 3 + static_cast<int>(seed % 6);
    const WayCase c = PlaneWays(n, 1 + static_cast<int>(seed % 4), kClimbs[seed % 3], seed);
    for (const Ends& ends : kAllEnds) {
      SCOPED_TRACE(testing::Message()
                   << "seed " << seed << ", entry " << ends.entry << ", exit " << ends.exit);
      const double least = test::LeastOfAll(RealTour(c, ends).Problem());
      const Status status = Plan(c, ends);
      if (least < WayCase::kNoWay) {
        ASSERT_EQ(status, Status::kOk);
        EXPECT_NEAR(plan_.length(), least, 1e-5);
        EXPECT_NEAR(plan_.bound(), least, 1e-5);
      } else {
        EXPECT_EQ(status, Status::kInfeasible);
      }
    }
  }
}

TEST_F(MultiGoalTest, IsTheBestOfAllPermutationsWhereWaysAreMissing) {
  int infeasible = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const int n = 3 + static_cast<int>(seed % 5);
    const WayCase c = RandomWays(n, seed % 2 == 0, 10 + static_cast<int>(seed % 50), seed);
    for (const Ends& ends : kAllEnds) {
      SCOPED_TRACE(testing::Message()
                   << "seed " << seed << ", entry " << ends.entry << ", exit " << ends.exit);
      const double least = test::LeastOfAll(RealTour(c, ends).Problem());
      const Status status = Plan(c, ends);
      if (least < WayCase::kNoWay) {
        ASSERT_EQ(status, Status::kOk);
        EXPECT_EQ(plan_.length(), least);
      } else {
        EXPECT_EQ(status, Status::kInfeasible);
        EXPECT_TRUE(order_.empty());
        ++infeasible;
      }
    }
  }
  EXPECT_GT(infeasible, 30);
  EXPECT_LT(infeasible, 200);
}

TEST_F(MultiGoalTest, IsAsGoodAsTheBestTourOfAllRealWays) {
  TourSolver solver(12);
  for (unsigned seed = 0; seed < 24; ++seed) {
    const int n = 9 + static_cast<int>(seed % 4);
    const WayCase c = seed % 3 == 0 ? RandomWays(n, seed % 2 == 0, 20, seed)
                                    : PlaneWays(n, 5, kClimbs[seed / 3 % 3], seed);
    for (const Ends& ends : kAllEnds) {
      SCOPED_TRACE(testing::Message()
                   << "seed " << seed << ", entry " << ends.entry << ", exit " << ends.exit);
      const TourCase tour = RealTour(c, ends);
      Order order(n);
      const Result<TourFigures> best = solver.Solve(tour.Problem(), {}, 1, order);
      ASSERT_TRUE(best.ok());
      if (best->cost < WayCase::kNoWay) {
        ASSERT_EQ(Plan(c, ends), Status::kOk);
        EXPECT_NEAR(plan_.length(), best->cost, 1e-5 * best->cost);
      } else {
        EXPECT_EQ(Plan(c, ends), Status::kInfeasible);
      }
    }
  }
}

TEST_F(MultiGoalTest, AsksForFewWaysOfManyAndIsNearTheBestOfAll) {
  struct Size {
    int goals;
    Climb climb;
    int queries_max;
  };
  constexpr Size kSizes[] = {{40, Climb::kNone, 60},       // of 780
                             {120, Climb::kNone, 180},     // of 7,140
                             {40, Climb::kKnown, 120},     // of 1,560
                             {120, Climb::kKnown, 360},    // of 14,280
                             {40, Climb::kUnknown, 500}};  // of 1,560, by bounds far too low
  TourSolver solver(120);
  for (const Size& size : kSizes) {
    for (unsigned seed = 0; seed < 3; ++seed) {
      SCOPED_TRACE(testing::Message() << size.queries_max << " queries, seed " << seed);
      const WayCase c = PlaneWays(size.goals, 6, size.climb, seed);
      ASSERT_EQ(Plan(c, {}), Status::kOk);
      EXPECT_LE(plan_.queries(), size.queries_max);
      EXPECT_LE(plan_.rounds(), plan_.queries() + 1);
      Order order(size.goals);
      const Result<TourFigures> best = solver.Solve(c.RealTour().Problem(), {}, 1, order);
      ASSERT_TRUE(best.ok());
      EXPECT_LE(plan_.length(), 1.01 * best->cost);
      EXPECT_LE(plan_.bound(), best->cost + 1e-5);
    }
  }
}

TEST_F(MultiGoalTest, AsksForNoMoreThanTheTourWhereBoundsAreReal) {
  const WayCase c = PlaneWays(60, 0, Climb::kKnown, 3);
  EXPECT_EQ(Plan(c, {}), Status::kOk);
  EXPECT_EQ(plan_.queries(), 60);
  EXPECT_EQ(plan_.rounds(), 1);
}

TEST_F(MultiGoalTest, AsksForNothingWhereItIsToldTheOrderThatItFound) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const WayCase c =
        seed < 5 ? PlaneWays(30, 6, Climb::kKnown, seed) : RandomWays(9, seed % 2 == 0, 20, seed);
    GoalWays ways = c.Ways();
    CaseWays planner(c);
    counted_ = 0;
    ASSERT_EQ(Plan(c, {.open = true}, ways, planner), Status::kOk);
    const Order first = order_;
    const double length = plan_.length();
    ASSERT_EQ(plan_.Solve({.goals = c.Goals(), .open = true, .known = first}, {}, 1, ways, planner),
              Status::kOk);
    EXPECT_EQ(plan_.queries(), 0);
    EXPECT_EQ(Order(plan_.order().begin(), plan_.order().end()), first);
    EXPECT_EQ(plan_.length(), length);
  }
}

TEST_F(MultiGoalTest, AsksOnlyForWaysOfAGoalThatMovedAndThoseNotKnown) {
  for (const Climb climb : kClimbs) {
    const WayCase before = PlaneWays(11, 4, climb, 21);
    counted_ = 0;
    WayCase after = before;
    GoalWays ways = before.Ways();
    CaseWays planner(after);
    ASSERT_EQ(Plan(before, {}, ways, planner), Status::kOk);
    const std::int64_t all = plan_.queries();
    for (int other = 0; other < 11; ++other) {  // it has moved away, so that bounds still hold
      after.Real(4, other) += 0.3F;
      after.Real(other, 4) += 0.3F;
    }
    planner.Forget(4);
    ASSERT_EQ(ways.SetBounds(4, before.Goals(), [&](int i, int j) { return before.Bound(i, j); }),
              Status::kOk);
    ASSERT_EQ(Plan(after, {}, ways, planner), Status::kOk);
    EXPECT_NEAR(plan_.length(), TourCost(after.RealTour().Problem(), order_), 1e-9);
    EXPECT_LT(plan_.queries(), all);
    const double mended = plan_.length();
    ASSERT_EQ(Plan(after, {}), Status::kOk);
    EXPECT_NEAR(mended, plan_.length(), 1e-5);
  }
}

TEST_F(MultiGoalTest, SegmentsOverTheirOwnGoalsShareWhatWasPlanned) {
  const WayCase c = PlaneWays(30, 5, Climb::kNone, 8);
  GoalWays ways = c.Ways();
  CaseWays planner(c);  // fails where one asks for what another knows
  const Order segments[] = {{3, 17, 9, 4, 25}, {25, 8, 1, 29, 30 - 3}, {9, 4, 17, 25, 3, 8}};
  for (const Order& goals : segments) {
    const int entry = goals.front();
    const int exit = goals.back();
    ASSERT_EQ(plan_.Solve({.goals = goals, .open = true, .entry = entry, .exit = exit}, {}, 1, ways,
                          planner),
              Status::kOk);
    EXPECT_EQ(plan_.order().front(), entry);
    EXPECT_EQ(plan_.order().back(), exit);
    TourCase part{.n = static_cast<int>(goals.size()), .open = true, .entry = 0};
    part.exit = part.n - 1;
    for (const int from : goals) {
      for (const int to : goals) {
        part.costs.push_back(c.Real(from, to));
      }
    }
    EXPECT_NEAR(plan_.length(), test::LeastOfAll(part.Problem()), 1e-5);
    EXPECT_EQ(std::set<TourNode>(goals.begin(), goals.end()),
              std::set<TourNode>(plan_.order().begin(), plan_.order().end()));
  }
}

TEST_F(MultiGoalTest, IsTheSameEveryTime) {
  const WayCase c = PlaneWays(70, 6, Climb::kKnown, 2);
  ASSERT_EQ(Plan(c, {.open = true, .entry = 2}), Status::kOk);
  const Order first = order_;
  const std::int64_t queries = plan_.queries();
  MultiGoal other(70);
  GoalWays ways = c.Ways();
  CaseWays planner(c);
  ASSERT_EQ(other.Solve({.goals = c.Goals(), .open = true, .entry = 2}, {}, 1, ways, planner),
            Status::kOk);
  EXPECT_EQ(Order(other.order().begin(), other.order().end()), first);
  EXPECT_EQ(other.queries(), queries);
}

}  // namespace
}  // namespace pipewright
