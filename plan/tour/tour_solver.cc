// SPDX-License-Identifier: MIT
#include "plan/tour/tour_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "plan/tour/held_karp.h"

namespace pipewright {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

TourSolver::TourSolver(int node_capacity)
    : node_capacity_(node_capacity),
      costs_(node_capacity, HeldKarp::kNodesMax * HeldKarp::kNodesMax + HeldKarp::kFloats),
      assignment_(node_capacity + 1),
      neighbours_(node_capacity + 1),
      construction_(node_capacity + 1),
      tour_(node_capacity + 1),
      local_search_(node_capacity + 1),
      assembly_(node_capacity + 1),
      members_(static_cast<std::size_t>(kMembers) * (node_capacity + 1)),
      scratch_(node_capacity + 1),
      best_(node_capacity + 1) {
  assert(1 <= node_capacity && node_capacity <= kCapacityMax);
}

Result<TourFigures> TourSolver::Solve(const TourProblem& problem, const TourBudget& budget,
                                      std::uint64_t seed, std::span<TourNode> order) {
  if (const Status status = CheckTour(problem); status != Status::kOk) {
    return status;
  }
  if (problem.n > node_capacity_) {
    return Status::kFull;
  }
  if (order.size() != static_cast<std::size_t>(problem.n)) {
    return Status::kMalformed;
  }
  TourFigures figures;
  if (problem.n == 1) {
    order[0] = 0;
    return figures;
  }
  if (problem.n < HeldKarp::kNodesMax) {
    costs_.Load(problem, false);
    HeldKarp::Solve(costs_, costs_.Spare(),
                    {best_.data(), static_cast<std::size_t>(costs_.size())});
    CopyOut(problem, order);
    figures.cost = figures.bound = TourCost(problem, order);
    return figures;
  }
  TourClock clock(budget);
  Search(problem, seed, clock);
  CopyOut(problem, order);
  figures.cost = TourCost(problem, order);
  figures.bound = std::min(figures.cost, assignment_.Bound() - costs_.DummyCost());
  figures.trials = clock.trials();
  figures.best_trial = best_trial_;
  return figures;
}

void TourSolver::Search(const TourProblem& problem, std::uint64_t seed, TourClock& clock) {
  constexpr double kRounding = 1e-7;
  costs_.Load(problem, true);
  assignment_.Solve(costs_, clock);
  costs_.Reduce(assignment_.u(), assignment_.v());
  neighbours_.Find(costs_);
  local_search_.Begin(costs_);
  best_length_ = kInfinity;
  proven_length_ = kRounding * std::abs(assignment_.Bound() - costs_.DummyCost());
  Rng rng(seed);
  do {
    Populate(problem, rng, clock);
    while (!Proven() && Evolve(rng, clock)) {
    }
  } while (!Proven() && !clock.Over());
}

/// Takes tour_ as that member.
void TourSolver::Keep(int member, const TourClock& clock) {
  std::copy(tour_.order().begin(), tour_.order().end(), Member(member).begin());
  lengths_[member] = tour_.Length();
  if (lengths_[member] < best_length_) {
    best_length_ = lengths_[member];
    best_trial_ = clock.trials();
    std::copy(tour_.order().begin(), tour_.order().end(), best_.begin());
  }
}

/// Fills the population until the clock is over: with the best tour so far, or else the assignment
/// with its parts joined, and with what is built at random.
void TourSolver::Populate(const TourProblem& problem, Rng& rng, TourClock& clock) {
  int built = 0;
  if (best_length_ < kInfinity) {
    std::copy_n(best_.begin(), costs_.size(), Member(0).begin());
    lengths_[0] = best_length_;
    built = 1;
  } else if (JoinAssignment()) {
    ImproveAll(clock);
    Keep(0, clock);
    built = 1;
  }
  for (; built < kMembers && !Proven() && (built == 0 || !clock.Over()); ++built) {
    construction_.Build(problem, costs_, neighbours_, rng, Member(built));
    tour_.Assign(Member(built), costs_);
    ImproveAll(clock);
    Keep(built, clock);
  }
}

/// Of symmetric costs the assignment is mostly pairs, and no better a start than any.
bool TourSolver::JoinAssignment() {
  if (costs_.symmetric() || assignment_.next().empty() ||
      !assembly_.JoinParts(assignment_.next(), costs_, neighbours_)) {
    return false;
  }
  TakeChild();
  return true;
}

/// Brings tour_ down to a local optimum, wherever it is not.
void TourSolver::ImproveAll(TourClock& clock) {
  for (const TourNode a : tour_.order()) {
    local_search_.Push(a);
  }
  Improve(clock);
}

void TourSolver::Improve(TourClock& clock) {
  clock.CountTrial();
  local_search_.Descend(tour_, costs_, neighbours_, clock);
}

void TourSolver::TakeChild() {
  const std::span order(scratch_.data(), static_cast<std::size_t>(costs_.size()));
  assembly_.child().CopyOrder(order);
  tour_.Assign(order, assembly_.child().cost_out());
}

/// One generation: round a random circle, each member takes from the next. @returns whether one got
/// better, and there is time
bool TourSolver::Evolve(Rng& rng, TourClock& clock) {
  int circle[kMembers];
  std::iota(circle, circle + kMembers, 0);
  for (int k = kMembers - 1; k > 0; --k) {
    std::swap(circle[k], circle[rng.Index(k + 1)]);
  }
  bool better = false;
  for (int k = 0; k < kMembers && !clock.Over() && !Proven(); ++k) {
    better = Mate(circle[k], circle[(k + 1) % kMembers], rng, clock) || better;
  }
  return better && !clock.Over();
}

/// Member a becomes the first of its children with member b that is shorter. @returns whether one
/// is
bool TourSolver::Mate(int a, int b, Rng& rng, TourClock& clock) {
  const int cycles = assembly_.Begin(Member(a), Member(b), costs_);
  if (cycles < 2) {  // of a single one, the child is b
    return false;
  }
  const int first = rng.Index(cycles);
  for (int k = 0; k < std::min(cycles, kChildren) && !clock.Over(); ++k) {
    if (ImproveChild((first + k) % cycles, clock) && tour_.Length() < lengths_[a]) {
      Keep(a, clock);
      return true;
    }
  }
  return false;
}

/// Brings the child of cycle k down to a local optimum, in tour_. @returns whether there is one
bool TourSolver::ImproveChild(int k, TourClock& clock) {
  if (!assembly_.MakeChild(k, costs_, neighbours_)) {
    return false;
  }
  TakeChild();
  for (const TourNode x : tour_.order()) {
    if (assembly_.Differs(x)) {
      local_search_.Push(x);
      local_search_.Push(tour_.Next(x));
    }
  }
  Improve(clock);
  return true;
}

/// The best tour, of an open problem from after the dummy on, the right way round.
void TourSolver::CopyOut(const TourProblem& problem, std::span<TourNode> order) {
  const auto nodes = best_.begin() + costs_.size();
  if (problem.open) {
    std::rotate(best_.begin(), std::find(best_.begin(), nodes, costs_.dummy()), nodes);
    std::copy(best_.begin() + 1, nodes, order.begin());
  } else {
    std::copy(best_.begin(), nodes, order.begin());
  }
  const bool entry_last = problem.entry != TourProblem::kFree && order.back() == problem.entry;
  const bool exit_first = problem.exit != TourProblem::kFree && order.front() == problem.exit;
  if (entry_last || exit_first) {  // symmetric costs alone do not tell
    std::reverse(order.begin(), order.end());
  }
}

std::size_t TourSolver::MemoryBytes() const {
  return sizeof(*this) + costs_.MemoryBytes() + assignment_.MemoryBytes() +
         neighbours_.MemoryBytes() + construction_.MemoryBytes() + tour_.MemoryBytes() +
         local_search_.MemoryBytes() + assembly_.MemoryBytes() +
         (members_.capacity() + scratch_.capacity() + best_.capacity()) * sizeof(TourNode);
}

}  // namespace pipewright
