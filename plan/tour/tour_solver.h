// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plan/tour/array_tour.h"
#include "plan/tour/assignment.h"
#include "plan/tour/construction.h"
#include "plan/tour/cost_table.h"
#include "plan/tour/edge_assembly.h"
#include "plan/tour/local_search.h"
#include "plan/tour/neighbours.h"
#include "plan/tour/tour_clock.h"
#include "plan/tour/tour_problem.h"
#include "platform/core/rng.h"
#include "platform/core/status.h"

namespace pipewright {

/// What a tour costs, and how much less another could.
struct TourFigures {
  double cost = 0;
  double bound = 0;             ///< no tour costs less
  std::int64_t trials = 0;      ///< that were made; fewer than asked for where cost = bound
  std::int64_t best_trial = 0;  ///< the one that found the tour, from 1 on; 0 where none was made
};

/// Good tours of up to some hundred nodes in milliseconds, closed or open, symmetric or not.
///
/// Up to 12 nodes, the best one (HeldKarp), whatever the budget. Else a population of tours is
/// built at random, and from the assignment, each brought down to a local optimum; then each in
/// turn takes from another a cycle of ways that leaves it shorter after a local search
/// (EdgeAssembly, LocalSearch), until none gets any shorter, and another population begins around
/// the best. All costs are reduced by the duals of the assignment problem first.
///
/// Deterministic: the same problem, seed and number of trials give the same tour, wherever the
/// clock is not what ends it. All memory is taken at construction: 1.1 MiB for 512 nodes.
class TourSolver {
 public:
  static constexpr int kCapacityMax = 4096;

  /// For up to `node_capacity` nodes, in [1, kCapacityMax].
  explicit TourSolver(int node_capacity);

  /// Puts the best tour found within the budget into `order`. Anytime: a deadline that is past
  /// gives a constructed tour.
  /// @returns what it costs; as CheckTour(); kFull: more nodes than there is room for; kMalformed:
  ///   `order` has not n places
  Result<TourFigures> Solve(const TourProblem& problem, const TourBudget& budget,
                            std::uint64_t seed, std::span<TourNode> order);

  std::size_t MemoryBytes() const;

 private:
  static constexpr int kMembers = 30;
  static constexpr int kChildren = 8;  // at most, of two parents

  void Search(const TourProblem& problem, std::uint64_t seed, TourClock& clock);
  void Populate(const TourProblem& problem, Rng& rng, TourClock& clock);
  bool JoinAssignment();
  void ImproveAll(TourClock& clock);
  void Improve(TourClock& clock);
  void TakeChild();
  bool Evolve(Rng& rng, TourClock& clock);
  bool Mate(int a, int b, Rng& rng, TourClock& clock);
  bool ImproveChild(int k, TourClock& clock);
  void Keep(int member, const TourClock& clock);
  void CopyOut(const TourProblem& problem, std::span<TourNode> order);
  bool Proven() const { return best_length_ <= proven_length_; }
  std::span<TourNode> Member(int k) {
    return {&members_[static_cast<std::size_t>(k) * costs_.size()],
            static_cast<std::size_t>(costs_.size())};
  }

  int node_capacity_;
  CostTable costs_;
  Assignment assignment_;
  Neighbours neighbours_;
  Construction construction_;
  ArrayTour tour_;
  LocalSearch local_search_;
  EdgeAssembly assembly_;
  std::vector<TourNode> members_;  // their orders, one after the other
  std::vector<TourNode> scratch_, best_;
  double lengths_[kMembers]{};  // of reduced costs, as all lengths here
  double best_length_ = 0;
  std::int64_t best_trial_ = 0;
  double proven_length_ = 0;
};

}  // namespace pipewright
