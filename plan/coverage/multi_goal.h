// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plan/coverage/goal_ways.h"
#include "plan/tour/tour_clock.h"
#include "plan/tour/tour_problem.h"
#include "plan/tour/tour_solver.h"
#include "platform/core/status.h"

namespace pipewright {

/// Plans the real way between two goals, which may take long. Plans are deterministic if its
/// answers do not depend on what was asked before.
class WayPlanner {
 public:
  virtual ~WayPlanner() = default;
  /// @returns the way; any status but kOk: none was found, and none is looked for again, unless the
  ///   deadline is past by then. Where GoalWays are symmetric, from < to
  virtual Result<RealWay> Plan(int from, int to) = 0;
};

/// Visit each goal once, in the best order: as TourProblem, but of goals by their indices in a
/// GoalWays. An unresolved segment of a tour is an open one, from its entry gate over its share of
/// goals to its exit gate; if the gates are one and the same, it is closed.
struct MultiGoalProblem {
  std::span<const TourNode> goals = {};  ///< each once, in any order; with the ends
  bool open = false;
  int entry = TourProblem::kFree;
  int exit = TourProblem::kFree;
  /// An order of these goals from before, or empty: where all its ways are still planned and free,
  /// the plan is no longer than it.
  std::span<const TourNode> known = {};
};

/// When a plan stops, if nothing else stops it first.
struct MultiGoalBudget {
  int rounds = 10'000;             ///< orders that are asked for
  std::int64_t queries = 100'000;  ///< ways that are asked for
  TourBudget tour = {};            ///< of each order; its deadline ends the whole
};

/// The multi-goal plan: a short tour of goals whose every way is real, where the length of a way is
/// dear to know and a lower bound is cheap. Lazy [Englot, Hover 2012]: no way is planned unless a
/// tour wants it.
///
///   c(i, j) = r(i, j)       where the way was planned; b(i, j) ≤ r(i, j), its bound, elsewhere
///   repeat  T ← TourSolver(c);  plan the ways of T that were not planned
///           if none of T is blocked, and r(T) < r(best): best ← T
///   until   c(T) ≥ r(best) before that, or no cost was changed by it
///
/// A way that is blocked costs more than any tour of others. All c(best) = r(best), so that either
/// end says that TourSolver finds no better order.
///
/// It ends: a round that is not the last changes a cost, by planning a way that was not planned; of
/// n goals, there are n(n − 1) ways, half as many where they are symmetric. Most rounds plan
/// several: of 120 goals round six rectangles in a plane, 2 to 4 rounds asked for 125 to 141 of
/// 7,140 ways; where each was longer by what it climbs, and the bound, too, 160 to 264 of 14,280.
/// Bounds far too low are dear: without the climb, 87 to 215 rounds asked for 1,028 to 1,433.
///
/// Up to 12 goals, TourSolver's T is the best by c, and then best is the best by r, if bounds are
/// bounds: c(T) ≤ c(T') ≤ r(T') for every T', whence c(T) ≥ r(best) leaves no T' that is shorter;
/// and where no cost was changed, r(T) = c(T). Of more goals, bound() says how much shorter another
/// might be: since c ≤ r, TourSolver's bound of any round holds for r, too. A way shorter than its
/// bound does no harm but to this.
///
/// What was planned stays in the GoalWays, and a plan over the same ones begins with it: told the
/// order of a plan that was kOk, it asks for no way; of one that the budget ended, it goes on.
///
/// Anytime and deterministic: the same arguments give the same plan, wherever the clock is not what
/// ends it. A round takes O(n²), TourSolver::Solve(), and the queries. All memory is taken at
/// construction: 2.1 MiB for 512 goals.
///
/// [Englot, Hover 2012] Sampling-based coverage path planning for inspection of complex structures.
class MultiGoal {
 public:
  /// For problems of up to `goal_capacity` goals, in [1, TourSolver::kCapacityMax].
  explicit MultiGoal(int goal_capacity);

  /// @returns kOk: order() is the best that was found, see above. kInfeasible: there is none
  ///   without a blocked way, or entry = exit; if goals are the reason, unreached() tells which.
  ///   kIterationLimit: the budget is over, or TourSolver found no way round the blocked ones,
  ///   though it has no proof that there is none; order() is the best so far, and empty if there is
  ///   none yet. Otherwise there is no order: kFull: more goals than there is room for;
  ///   kOutOfRange: a goal is none of `ways`, or an end none of the goals, or a length that the
  ///   planner gave is not in [0, GoalWays::kLengthMax]; kMalformed: a goal is there twice, or a
  ///   closed plan has ends, or `known` is no order of the goals from entry to exit
  Status Solve(const MultiGoalProblem& problem, const MultiGoalBudget& budget, std::uint64_t seed,
               GoalWays& ways, WayPlanner& planner);

  /// The goals, each way from one to the next planned and free.
  std::span<const TourNode> order() const { return order_; }
  double length() const { return length_; }  ///< of the order; 0 where there is none
  double bound() const { return bound_; }    ///< no order is shorter
  /// Goals that no tour can reach, or leave, but by a blocked way: see FindCutOff().
  std::span<const TourNode> unreached() const { return unreached_; }
  int rounds() const { return rounds_; }
  std::int64_t queries() const { return queries_; }
  std::int64_t trials() const { return trials_; }  ///< TourSolver's, of all rounds

  std::size_t MemoryBytes() const;

 private:
  enum class Checked : std::uint8_t { kSame, kChanged, kOver, kBadLength };

  void Clear();
  Status Admit(const MultiGoalProblem& problem, const GoalWays& ways);
  Status TakeKnown(std::span<const TourNode> known, const GoalWays& ways);
  Status Search(const MultiGoalBudget& budget, std::uint64_t seed, GoalWays& ways,
                WayPlanner& planner);
  double FillCosts(const GoalWays& ways);
  Checked CheckWays(const MultiGoalBudget& budget, GoalWays& ways, WayPlanner& planner);
  void KeepIfBest(const GoalWays& ways);
  int WayCount() const { return tour_.open ? tour_.n - 1 : tour_.n; }
  TourNode From(int k) const { return goals_[places_[k]]; }
  TourNode To(int k) const { return goals_[places_[k + 1 == tour_.n ? 0 : k + 1]]; }

  int goal_capacity_;
  TourSolver solver_;
  TourProblem tour_;  // of places in goals_
  std::vector<float> costs_;
  std::vector<TourNode> goals_, places_;
  std::vector<TourNode> order_, unreached_;
  double length_ = 0;
  double bound_ = 0;
  int rounds_ = 0;
  std::int64_t queries_ = 0;
  std::int64_t trials_ = 0;
};

}  // namespace pipewright
