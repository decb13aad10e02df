// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "plan/tour/cost_table.h"
#include "plan/tour/tour_clock.h"

namespace pipewright {

/// The linear assignment of each node's successor, as if several tours were allowed: its dual is a
/// lower bound of every tour's cost, and its reduced costs c − u − v ≥ 0 tell how much dearer than
/// the bound a tour becomes that takes a way. They rank ways far better than the costs do.
///
///   maximise Σ u(i) + Σ v(j)   subject to   u(i) + v(j) ≤ c(i, j),  i ≠ j
///
/// [Jonker, Volgenant: A shortest augmenting path algorithm for dense and sparse linear assignment
/// problems, Computing 38, 1987]. O(n³) at worst; all memory is taken at construction.
class Assignment {
 public:
  explicit Assignment(int node_capacity);

  /// Solves; at the clock's end, leaves duals that are feasible and not yet the best. Of symmetric
  /// costs, u = v.
  void Solve(const CostTable& costs, TourClock& clock);

  std::span<const float> u() const { return u_; }
  std::span<const float> v() const { return v_; }
  double Bound() const;  ///< Σ u + Σ v
  /// Every node's successor in the assignment; empty where it was cut short.
  std::span<const TourNode> next() const;
  std::size_t MemoryBytes() const;

 private:
  static constexpr TourNode kNone = -1;

  void ReduceColumns(const CostTable& costs);
  void ReduceRows(const CostTable& costs);
  void Augment(const CostTable& costs, TourNode row);
  TourNode SettleUntilFree(const CostTable& costs, TourNode row);
  void SetRowDuals(const CostTable& costs);

  int n_ = 0;
  std::vector<float> u_, v_, distance_;
  std::vector<TourNode> column_of_, row_of_;  // the assignment so far
  std::vector<TourNode> free_rows_, predecessor_, columns_;
  int free_count_ = 0;  // rows without a column
  int settled_ = 0;     // of columns_, those whose distance is final come first
};

}  // namespace pipewright
