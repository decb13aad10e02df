// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "plan/tour/tour_problem.h"

namespace pipewright {

/// The costs of a closed tour: the problem's own or, of an open one, with a dummy node n between
/// exit and entry. Ways of the dummy cost 0 where the end is free or the one given, elsewhere
/// Forbidden(), so that the same search serves all kinds.
class CostTable {
 public:
  static constexpr float kNever = 1e30F;  ///< of a node to itself

  /// Room for `node_capacity` nodes and the dummy; SpareFloats() beyond a small problem's table.
  CostTable(int node_capacity, int floats_min);

  /// Copies a problem that CheckTour() accepts. Costs that are the same both ways stay so with the
  /// dummy, whose ways then do not tell entry from exit, if `may_be_symmetric`.
  void Load(const TourProblem& problem, bool may_be_symmetric);

  int size() const { return n_; }  ///< nodes, with the dummy
  bool symmetric() const { return symmetric_; }
  /// The dummy, or -1 of a closed tour.
  int dummy() const { return dummy_; }
  /// What a way costs that breaks an end: more than any 3 others, so that no exchange of 3 ways
  /// that gains anything takes one in. Infinite where there is no dummy.
  float Forbidden() const { return forbidden_; }
  /// What every tour must pay for the dummy.
  float DummyCost() const { return dummy_cost_; }

  float operator()(int from, int to) const {
    return costs_[static_cast<std::size_t>(from) * static_cast<std::size_t>(n_) +
                  static_cast<std::size_t>(to)];
  }
  const float* Row(int from) const { return &costs_[static_cast<std::size_t>(from) * n_]; }

  /// c(i, j) ← c(i, j) − u(i) − v(j): every tour's cost falls by Σ u + Σ v, no order changes.
  void Reduce(std::span<const float> u, std::span<const float> v);

  /// What the table leaves free of the memory.
  std::span<float> Spare();
  std::size_t MemoryBytes() const { return costs_.capacity() * sizeof(float); }

 private:
  void AddDummy(const TourProblem& problem);

  std::vector<float> costs_;
  int n_ = 0;
  int dummy_ = -1;
  bool symmetric_ = false;
  float forbidden_ = 0;
  float dummy_cost_ = 0;
};

}  // namespace pipewright
