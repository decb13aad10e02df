// SPDX-License-Identifier: MIT
#include "plan/coverage/multi_goal.h"

#include <algorithm>
#include <bitset>
#include <cassert>
#include <cmath>
#include <span>

#include "plan/coverage/cut_off.h"

namespace pipewright {
namespace {

bool Late(const TourBudget& budget) {
  return budget.now != nullptr && budget.now() >= budget.deadline;
}

}  // namespace

MultiGoal::MultiGoal(int goal_capacity)
    : goal_capacity_(goal_capacity),
      solver_(goal_capacity),
      costs_(static_cast<std::size_t>(goal_capacity) * static_cast<std::size_t>(goal_capacity)) {
  goals_.reserve(goal_capacity);
  places_.reserve(goal_capacity);
  order_.reserve(goal_capacity);
  unreached_.reserve(goal_capacity);
}

Status MultiGoal::Solve(const MultiGoalProblem& problem, const MultiGoalBudget& budget,
                        std::uint64_t seed, GoalWays& ways, WayPlanner& planner) {
  Clear();
  Status status = Admit(problem, ways);
  if (status != Status::kOk) {
    return status;
  }
  status = TakeKnown(problem.known, ways);
  if (status != Status::kOk) {
    return status;
  }
  if (problem.goals.size() < 2) {
    order_.assign(problem.goals.begin(), problem.goals.end());
    return Status::kOk;
  }
  status = Search(budget, seed, ways, planner);
  if (status == Status::kOutOfRange) {
    Clear();
  }
  bound_ = order_.empty() ? bound_ : std::min(bound_, length_);
  return status;
}

void MultiGoal::Clear() {
  order_.clear();
  unreached_.clear();
  length_ = 0;
  bound_ = 0;
  rounds_ = 0;
  queries_ = 0;
  trials_ = 0;
}

Status MultiGoal::Admit(const MultiGoalProblem& p, const GoalWays& ways) {
  if (p.goals.size() > static_cast<std::size_t>(goal_capacity_)) {
    return Status::kFull;
  }
  if (!p.open && (p.entry != TourProblem::kFree || p.exit != TourProblem::kFree)) {
    return Status::kMalformed;
  }
  std::bitset<GoalWays::kCapacityMax> there;
  for (const TourNode goal : p.goals) {
    if (goal < 0 || goal >= ways.capacity()) {
      return Status::kOutOfRange;
    }
    if (there[goal]) {
      return Status::kMalformed;
    }
    there[goal] = true;
  }
  const auto place = [&](int end) {  // the number of goals where it is none
    return static_cast<int>(std::find(p.goals.begin(), p.goals.end(), end) - p.goals.begin());
  };
  const int n = static_cast<int>(p.goals.size());
  tour_ = {.n = n, .open = p.open};
  tour_.entry = p.entry == TourProblem::kFree ? TourProblem::kFree : place(p.entry);
  tour_.exit = p.exit == TourProblem::kFree ? TourProblem::kFree : place(p.exit);
  if (tour_.entry == n || tour_.exit == n) {
    return Status::kOutOfRange;
  }
  goals_.assign(p.goals.begin(), p.goals.end());
  places_.resize(n);
  tour_.costs = std::span(costs_).first(p.goals.size() * p.goals.size());
  return tour_.entry != TourProblem::kFree && tour_.entry == tour_.exit && n > 1
             ? Status::kInfeasible
             : Status::kOk;
}

Status MultiGoal::TakeKnown(std::span<const TourNode> known, const GoalWays& ways) {
  if (known.empty()) {
    return Status::kOk;
  }
  if (known.size() != goals_.size() ||
      !std::is_permutation(known.begin(), known.end(), goals_.begin())) {
    return Status::kMalformed;
  }
  for (std::size_t k = 0; k < known.size(); ++k) {
    const auto goal = std::find(goals_.begin(), goals_.end(), known[k]);
    places_[k] = static_cast<TourNode>(goal - goals_.begin());
  }
  if ((tour_.entry != TourProblem::kFree && places_.front() != tour_.entry) ||
      (tour_.exit != TourProblem::kFree && places_.back() != tour_.exit)) {
    return Status::kMalformed;
  }
  bool planned = tour_.n > 1;
  for (int k = 0; planned && k < WayCount(); ++k) {
    planned = ways.IsPlanned(From(k), To(k));
  }
  if (planned) {
    KeepIfBest(ways);
  }
  return Status::kOk;
}

Status MultiGoal::Search(const MultiGoalBudget& budget, std::uint64_t seed, GoalWays& ways,
                         WayPlanner& planner) {
  while (rounds_ < budget.rounds && !Late(budget.tour)) {
    ++rounds_;
    const double blocked = FillCosts(ways);
    const Result<TourFigures> tour = solver_.Solve(tour_, budget.tour, seed, places_);
    assert(tour.ok());
    const Status end = Late(budget.tour) ? Status::kIterationLimit : Status::kOk;
    trials_ += tour->trials;
    bound_ = tour->bound < blocked ? std::max(bound_, tour->bound) : bound_;
    if (!order_.empty() && tour->cost >= length_) {
      return end;
    }
    if (tour->cost >= blocked) {
      FindCutOff(tour_, blocked, unreached_);
      for (TourNode& place : unreached_) {
        place = goals_[place];
      }
      return tour->bound >= blocked || !unreached_.empty() ? Status::kInfeasible
                                                           : Status::kIterationLimit;
    }
    const Checked checked = CheckWays(budget, ways, planner);
    if (checked == Checked::kOver) {
      break;
    }
    if (checked == Checked::kBadLength) {
      return Status::kOutOfRange;
    }
    KeepIfBest(ways);
    if (checked == Checked::kSame) {
      return end;
    }
  }
  return Status::kIterationLimit;
}

/// Costs by all that is known. @returns what no tour costs that takes no blocked way, and every
/// other does; near enough to either, since TourSolver's numbers are of float
double MultiGoal::FillCosts(const GoalWays& ways) {
  double sum = 0;  // of each goal's longest way: no tour is longer
  float* cost = costs_.data();
  for (const TourNode from : goals_) {
    float longest = 0;
    for (const TourNode to : goals_) {
      *cost = from == to ? 0 : ways.Length(from, to);
      longest = *cost <= GoalWays::kLengthMax ? std::max(longest, *cost) : longest;
      ++cost;
    }
    sum += longest;
  }
  sum = sum > 0 ? sum : 1;
  for (float& c : std::span(costs_.data(), cost)) {
    c = c <= GoalWays::kLengthMax ? c : static_cast<float>(2 * sum);
  }
  return 1.5 * sum;
}

/// Plans what was not planned of the tour.
MultiGoal::Checked MultiGoal::CheckWays(const MultiGoalBudget& budget, GoalWays& ways,
                                        WayPlanner& planner) {
  Checked checked = Checked::kSame;
  for (int k = 0; k < WayCount(); ++k) {
    const bool turn = ways.symmetric() && From(k) > To(k);
    const int from = turn ? To(k) : From(k);
    const int to = turn ? From(k) : To(k);
    if (ways.IsPlanned(from, to)) {
      continue;
    }
    if (queries_ >= budget.queries || Late(budget.tour)) {
      return Checked::kOver;
    }
    ++queries_;
    const float before = ways.Length(from, to);
    const Result<RealWay> way = planner.Plan(from, to);
    if (!way.ok() && Late(budget.tour)) {  // it may have been short of time alone
      return Checked::kOver;
    }
    if ((way.ok() ? ways.SetReal(from, to, *way) : ways.Block(from, to)) != Status::kOk) {
      return Checked::kBadLength;
    }
    checked = ways.Length(from, to) == before ? checked : Checked::kChanged;
  }
  return checked;
}

void MultiGoal::KeepIfBest(const GoalWays& ways) {
  double length = 0;  // infinite with a blocked way
  for (int k = 0; k < WayCount(); ++k) {
    length += ways.Length(From(k), To(k));
  }
  if (std::isfinite(length) && (order_.empty() || length < length_)) {
    length_ = length;
    order_.clear();
    for (const TourNode place : places_) {
      order_.push_back(goals_[place]);
    }
  }
}

std::size_t MultiGoal::MemoryBytes() const {
  return sizeof(*this) - sizeof(solver_) + solver_.MemoryBytes() +
         costs_.capacity() * sizeof(float) +
         (goals_.capacity() + places_.capacity() + order_.capacity() + unreached_.capacity()) *
             sizeof(TourNode);
}

}  // namespace pipewright
