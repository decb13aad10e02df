// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "plan/tour/array_tour.h"
#include "plan/tour/neighbours.h"
#include "plan/tour/tour_clock.h"

namespace pipewright {

/// Makes a tour better by exchanging three of its ways, until no exchange that it looks at gains
/// anything.
///
///   Or-3opt  a→a', b→b', c→c'  become  a→b', b→c', c→a'    no piece is turned: costs may differ
///   2-opt    a→a', c→c'        become  a→c,  a'→c'         only where costs are the same both ways
///
/// Two of the new ways come from the neighbour lists, and each prefix of (way left − way taken)
/// gains. [Lin, Kernighan 1973] [Johnson, McGeoch: The travelling salesman problem: a case study,
/// 1997, sections 3.2, 3.3]: neighbour lists and a queue of the nodes that may have a move.
class LocalSearch {
 public:
  explicit LocalSearch(int node_capacity);

  /// Forgets the queue.
  void Begin(const CostTable& costs);
  /// Looks at a node (again).
  void Push(TourNode a);
  /// Improves the tour until the queue is empty or it is late. @returns how much shorter it is
  double Descend(ArrayTour& tour, const CostTable& costs, const Neighbours& neighbours,
                 TourClock& clock);

  std::size_t MemoryBytes() const;

 private:
  enum class Kind : std::uint8_t { kNone, kExchange, kTurn };

  /// The best exchange found so far: at a, b, c in the tour's order; of a turn, at a and c.
  struct Move {
    Kind kind = Kind::kNone;
    float gain = 0;
    TourNode a = 0;
    TourNode b = 0;
    TourNode c = 0;

    void Keep(const Move& other) { *this = other.gain > gain ? other : *this; }
  };

  TourNode Pop();
  static Move BestForwards(const ArrayTour& tour, const CostTable& costs,
                           const Neighbours& neighbours, TourNode a);
  static Move BestBackwards(const ArrayTour& tour, const CostTable& costs,
                            const Neighbours& neighbours, TourNode a1);
  double Apply(const Move& move, ArrayTour& tour, const CostTable& costs);

  std::vector<TourNode> queue_;  // a ring
  std::vector<std::uint8_t> queued_;
  int n_ = 0;
  int head_ = 0;
  int count_ = 0;
};

}  // namespace pipewright
