// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "plan/coverage/multi_goal.h"
#include "tests/plan/coverage/way_cases.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using test::CaseWays;
using test::Climb;
using test::PlaneWays;
using test::WayCase;
using Order = std::vector<TourNode>;

/// A case with the ways from and to a goal taken out.
WayCase Without(WayCase c, int goal, bool ways_in, bool ways_out) {
  for (int other = 0; other < c.n; ++other) {
    c.Real(other, goal) = ways_in ? WayCase::kNoWay : c.Real(other, goal);
    c.Real(goal, other) = ways_out ? WayCase::kNoWay : c.Real(goal, other);
  }
  return c;
}

/// Answers every question with this.
class Says : public WayPlanner {
 public:
  explicit Says(const Result<RealWay>& answer) : answer_(answer) {}
  Result<RealWay> Plan(int, int) override { return answer_; }

 private:
  Result<RealWay> answer_;
};

int g_reads = 0;
Time Read() { return Time{Duration{g_reads++}}; }

class MultiGoalLimitsTest : public testing::Test {
 protected:
  Status Plan(const WayCase& c, const MultiGoalProblem& problem,
              const MultiGoalBudget& budget = {}) {
    GoalWays ways = c.Ways();
    CaseWays planner(c);
    return plan_.Solve(problem, budget, 1, ways, planner);
  }
  Order Found() const { return {plan_.order().begin(), plan_.order().end()}; }
  Order Unreached() const { return {plan_.unreached().begin(), plan_.unreached().end()}; }

  MultiGoal plan_{40};
};

TEST_F(MultiGoalLimitsTest, TellsGoalsThatCannotBeReached) {
  for (const int n : {5, 12, 40}) {
    SCOPED_TRACE(n);
    const WayCase both = Without(PlaneWays(n, 2, Climb::kNone, 4), 3, true, true);
    EXPECT_EQ(Plan(both, {.goals = both.Goals()}), Status::kInfeasible);
    EXPECT_EQ(Unreached(), Order{3});
    EXPECT_TRUE(Found().empty());
    EXPECT_EQ(plan_.length(), 0);
  }
}

TEST_F(MultiGoalLimitsTest, TellsGoalsThatCannotBeReachedOrLeftUnlessTheyAreEnds) {
  for (const bool in : {false, true}) {
    for (const int n : {6, 20}) {
      const WayCase c = Without(PlaneWays(n, 1, Climb::kKnown, 4), 2, in, !in);
      const Order goals = c.Goals();
      EXPECT_EQ(Plan(c, {.goals = goals}), Status::kInfeasible);
      EXPECT_EQ(Unreached(), Order{2});
      EXPECT_EQ(Plan(c, {.goals = goals, .open = true, .entry = 2}),
                in ? Status::kOk : Status::kInfeasible);
      EXPECT_EQ(Plan(c, {.goals = goals, .open = true, .exit = 2}),
                in ? Status::kInfeasible : Status::kOk);
      EXPECT_EQ(Plan(c, {.goals = goals, .open = true}), Status::kOk);
      EXPECT_EQ(in ? plan_.order().front() : plan_.order().back(), 2);
      EXPECT_TRUE(Unreached().empty());
    }
  }
}

TEST_F(MultiGoalLimitsTest, KeepsTheBestOrderWhenTheBudgetIsOver) {
  const WayCase c = PlaneWays(40, 8, Climb::kNone, 6);
  const Order goals = c.Goals();
  ASSERT_EQ(Plan(c, {.goals = goals}), Status::kOk);
  const std::int64_t queries = plan_.queries();
  const int rounds = plan_.rounds();
  const double length = plan_.length();
  ASSERT_GT(rounds, 2);
  double last = std::numeric_limits<double>::infinity();
  int found = 0;
  for (int k = 0; k < rounds; ++k) {
    EXPECT_EQ(Plan(c, {.goals = goals}, {.rounds = k}), Status::kIterationLimit);
    EXPECT_EQ(plan_.rounds(), k);
    if (!Found().empty()) {
      EXPECT_TRUE(test::IsTour(c.RealTour().Problem(), Found()));
      EXPECT_DOUBLE_EQ(plan_.length(), TourCost(c.RealTour().Problem(), Found()));
      EXPECT_LE(plan_.length(), last);
      EXPECT_GE(plan_.length(), length);
      EXPECT_LE(plan_.bound(), plan_.length());
      last = plan_.length();
      ++found;
    }
  }
  EXPECT_GT(found, 0);
  EXPECT_EQ(Plan(c, {.goals = goals}, {.rounds = rounds}), Status::kOk);
  EXPECT_EQ(Plan(c, {.goals = goals}, {.queries = 39}), Status::kIterationLimit);
  EXPECT_TRUE(Found().empty());
  EXPECT_EQ(plan_.queries(), 39);
  EXPECT_EQ(Plan(c, {.goals = goals}, {.queries = queries - 1}), Status::kIterationLimit);
  EXPECT_EQ(plan_.queries(), queries - 1);
  EXPECT_EQ(Plan(c, {.goals = goals}, {.queries = queries}), Status::kOk);
}

TEST_F(MultiGoalLimitsTest, GoesOnFromTheOrderThatItIsTold) {
  const WayCase c = PlaneWays(40, 8, Climb::kUnknown, 6);
  const Order goals = c.Goals();
  GoalWays ways = c.Ways();
  CaseWays planner(c);
  Order known;
  double last = std::numeric_limits<double>::infinity();
  Status status = Status::kIterationLimit;
  int calls = 0;
  for (; status == Status::kIterationLimit && calls < 1000; ++calls) {
    status = plan_.Solve({.goals = goals, .known = known}, {.rounds = 3}, 1, ways, planner);
    ASSERT_FALSE(Found().empty());
    EXPECT_LE(plan_.length(), last);
    last = plan_.length();
    known = Found();
  }
  EXPECT_EQ(status, Status::kOk);
  EXPECT_GT(calls, 3);
  EXPECT_EQ(plan_.Solve({.goals = goals, .known = known}, {.rounds = 0}, 1, ways, planner),
            Status::kIterationLimit);
  EXPECT_EQ(Found(), known);
  EXPECT_EQ(ways.Block(known[0], known[1]), Status::kOk);
  EXPECT_EQ(plan_.Solve({.goals = goals, .known = known}, {.rounds = 0}, 1, ways, planner),
            Status::kIterationLimit);
  EXPECT_TRUE(Found().empty());
  EXPECT_EQ(ways.SetBound(known[0], known[1], 0), Status::kOk);
  EXPECT_EQ(plan_.Solve({.goals = goals, .known = known}, {.rounds = 0}, 1, ways, planner),
            Status::kIterationLimit);
  EXPECT_TRUE(Found().empty());
}

TEST_F(MultiGoalLimitsTest, EndsAtADeadlineAndGoesOnFromThere) {
  const WayCase c = PlaneWays(12, 4, Climb::kNone, 6);
  const Order goals = c.Goals();
  GoalWays ways = c.Ways();
  CaseWays planner(c);
  Status status = Status::kIterationLimit;
  int calls = 0;
  for (; status == Status::kIterationLimit && calls < 1000; ++calls) {
    g_reads = 0;
    const TourBudget tour{.now = Read, .deadline = Time{Duration{6}}};
    status = plan_.Solve({.goals = goals}, {.tour = tour}, 1, ways, planner);
    EXPECT_LE(plan_.queries(), 6);
  }
  EXPECT_EQ(status, Status::kOk);
  EXPECT_GT(calls, 2);
  const double length = plan_.length();
  ASSERT_EQ(Plan(c, {.goals = goals}), Status::kOk);
  EXPECT_NEAR(length, plan_.length(), 1e-5);
}

TEST_F(MultiGoalLimitsTest, TakesNoWayForBlockedThatWasNotFoundInTime) {
  GoalWays ways(3, false);
  Says in_vain(Status::kIterationLimit);
  g_reads = 0;  // the fourth: after the way, which follows two of the round and one before it
  const TourBudget tour{.now = Read, .deadline = Time{Duration{3}}};
  EXPECT_EQ(plan_.Solve({.goals = Order{0, 1, 2}}, {.tour = tour}, 1, ways, in_vain),
            Status::kIterationLimit);
  EXPECT_EQ(plan_.queries(), 1);
  for (const auto& [from, to] : {std::pair{0, 1}, {1, 0}, {0, 2}, {2, 0}, {1, 2}, {2, 1}}) {
    EXPECT_FALSE(ways.IsPlanned(from, to));
  }
}

TEST_F(MultiGoalLimitsTest, NothingAndOneGoalNeedNoWay) {
  GoalWays ways(3, true);
  Says none(Status::kFault);
  EXPECT_EQ(plan_.Solve({}, {}, 1, ways, none), Status::kOk);
  EXPECT_TRUE(Found().empty());
  for (const bool open : {false, true}) {
    const int end = open ? 2 : TourProblem::kFree;
    EXPECT_EQ(plan_.Solve({.goals = Order{2}, .open = open, .entry = end, .exit = end}, {}, 1, ways,
                          none),
              Status::kOk);
    EXPECT_EQ(Found(), Order{2});
    EXPECT_EQ(plan_.queries(), 0);
    EXPECT_EQ(plan_.length(), 0);
  }
}

TEST_F(MultiGoalLimitsTest, TwoGoalsAreAWayAndItsWayBackMayBeShorter) {
  for (const bool symmetric : {false, true}) {
    for (const bool open : {false, true}) {
      GoalWays ways(9, symmetric);
      Says three(RealWay{.length = 3});
      EXPECT_EQ(plan_.Solve({.goals = Order{7, 5}, .open = open}, {}, 1, ways, three), Status::kOk);
      EXPECT_EQ(plan_.length(), open ? 3 : 6);
      EXPECT_EQ(plan_.queries(), symmetric ? 1 : 2);
    }
    GoalWays ways(9, symmetric);
    Says three(RealWay{.length = 3});
    EXPECT_EQ(plan_.Solve({.goals = Order{7, 5}, .open = true, .entry = 5, .exit = 7}, {}, 1, ways,
                          three),
              Status::kOk);
    EXPECT_EQ(Found(), (Order{5, 7}));
    EXPECT_EQ(ways.Length(5, 7), 3);
  }
}

TEST_F(MultiGoalLimitsTest, RefusesWhatIsNoProblem) {
  GoalWays ways(50, true);
  Says three(RealWay{.length = 3});
  const auto ends = [&](const MultiGoalProblem& problem) {
    EXPECT_EQ(plan_.Solve({.goals = Order{0, 1, 2}}, {}, 1, ways, three), Status::kOk);
    const Status status = plan_.Solve(problem, {}, 1, ways, three);
    EXPECT_TRUE(Found().empty());
    EXPECT_EQ(plan_.length(), 0);
    EXPECT_EQ(plan_.rounds(), 0);
    return status;
  };
  EXPECT_EQ(ends({.goals = Order(41)}), Status::kFull);
  EXPECT_EQ(ends({.goals = Order{0, 50}}), Status::kOutOfRange);
  EXPECT_EQ(ends({.goals = Order{-1, 0}}), Status::kOutOfRange);
  EXPECT_EQ(ends({.goals = Order{1, 4, 1}}), Status::kMalformed);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .entry = 0}), Status::kMalformed);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .exit = 0}), Status::kMalformed);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .open = true, .entry = 2}), Status::kOutOfRange);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .open = true, .exit = -2}), Status::kOutOfRange);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .known = Order{0}}), Status::kMalformed);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .known = Order{0, 0}}), Status::kMalformed);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .known = Order{0, 2}}), Status::kMalformed);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .open = true, .entry = 1, .known = Order{0, 1}}),
            Status::kMalformed);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .open = true, .exit = 0, .known = Order{0, 1}}),
            Status::kMalformed);
  EXPECT_EQ(ends({.goals = {}, .open = true, .exit = 0}), Status::kOutOfRange);
  EXPECT_EQ(ends({.goals = Order{0, 1}, .open = true, .entry = 1, .exit = 1}), Status::kInfeasible);
}

TEST_F(MultiGoalLimitsTest, RefusesLengthsThatAreNone) {
  for (const float length : {-1.0F, std::numeric_limits<float>::quiet_NaN(), 1e9F}) {
    GoalWays ways(3, true);
    Says odd(RealWay{.length = length});
    EXPECT_EQ(plan_.Solve({.goals = Order{0, 1, 2}}, {}, 1, ways, odd), Status::kOutOfRange);
    EXPECT_TRUE(Found().empty());
    EXPECT_FALSE(ways.IsPlanned(0, 1));
  }
}

TEST_F(MultiGoalLimitsTest, TakesNothingFromTheHeap) {
  const WayCase c = PlaneWays(40, 6, Climb::kKnown, 9);
  const WayCase cut = Without(c, 7, true, true);
  const Order goals = c.Goals();
  GoalWays ways = c.Ways();
  GoalWays cut_ways = c.Ways();
  CaseWays planner(c);
  CaseWays cut_planner(cut);
  const test::NoAllocScope no_alloc;
  EXPECT_EQ(plan_.Solve({.goals = goals}, {}, 1, ways, planner), Status::kOk);
  EXPECT_EQ(plan_.Solve({.goals = goals}, {}, 1, cut_ways, cut_planner), Status::kInfeasible);
}

TEST_F(MultiGoalLimitsTest, TakesNoMemoryButWhatItSays) {
  const std::size_t solver = TourSolver(512).MemoryBytes() - sizeof(TourSolver);
  EXPECT_EQ(MultiGoal(512).MemoryBytes(), sizeof(MultiGoal) + solver + 512U * 512 * 4 + 512U * 8);
}

}  // namespace
}  // namespace pipewright
