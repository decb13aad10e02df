// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "plan/tour/cost_table.h"

namespace pipewright {

/// A closed tour as an array: who stands at which place, where each node stands, and what the way
/// out of each costs. An exchange moves the shortest pieces that will do.
class ArrayTour {
 public:
  explicit ArrayTour(int node_capacity);

  void Assign(std::span<const TourNode> order, const CostTable& costs);
  /// The same, of costs that are known by node.
  void Assign(std::span<const TourNode> order, std::span<const float> cost_out);

  int size() const { return n_; }
  std::span<const TourNode> order() const { return {order_.data(), static_cast<std::size_t>(n_)}; }
  double Length() const;

  TourNode Next(int a) const { return order_[Wrapped(place_[a] + 1)]; }
  TourNode Previous(int a) const { return order_[place_[a] == 0 ? n_ - 1 : place_[a] - 1]; }
  float CostOut(int a) const { return cost_out_[a]; }  ///< of the way from a to Next(a)
  /// Ways from a forwards to b, in [0, n).
  int Steps(int a, int b) const {
    const int steps = place_[b] - place_[a];
    return steps < 0 ? steps + n_ : steps;
  }

  /// Or-3opt: with a', b', c' the successors, and a, b, c in the tour's order, exchanges the pieces
  /// a' … b and b' … c. No way but three changes: a→b', c→a', b→c'. O(n/2) moved at most.
  void ExchangePieces(TourNode a, TourNode b, TourNode c, const CostTable& costs);

  /// 2-opt, of costs that are the same both ways: turns a' … c, or all else, so that a stands
  /// beside c, and a' beside c'.
  void TurnPiece(TourNode a, TourNode c, const CostTable& costs);

  std::size_t MemoryBytes() const;

 private:
  int Wrapped(int place) const { return place >= n_ ? place - n_ : place; }
  void Put(int place, TourNode a) {
    order_[place] = a;
    place_[a] = static_cast<TourNode>(place);
  }
  void ExchangeAt(int place, int first, int second);
  void TurnAt(int place, int count, const CostTable& costs);

  int n_ = 0;
  std::vector<TourNode> order_, place_, moved_;
  std::vector<float> cost_out_;
};

}  // namespace pipewright
