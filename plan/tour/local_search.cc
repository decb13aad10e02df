// SPDX-License-Identifier: MIT
#include "plan/tour/local_search.h"

#include <algorithm>

namespace pipewright {

LocalSearch::LocalSearch(int node_capacity) : queue_(node_capacity), queued_(node_capacity) {}

void LocalSearch::Begin(const CostTable& costs) {
  n_ = costs.size();
  head_ = 0;
  count_ = 0;
  std::fill(queued_.begin(), queued_.end(), std::uint8_t{0});
}

void LocalSearch::Push(TourNode a) {
  if (queued_[a] == 0) {
    queued_[a] = 1;
    const int tail = head_ + count_++;
    queue_[tail >= n_ ? tail - n_ : tail] = a;
  }
}

TourNode LocalSearch::Pop() {
  const TourNode a = queue_[head_];
  head_ = head_ + 1 == n_ ? 0 : head_ + 1;
  --count_;
  queued_[a] = 0;
  return a;
}

/// Leaves a→a', takes a→b', leaves b→b', takes b→c', leaves c→c' and closes c→a'. Reduced costs are
/// not negative, so that a sum without the last way bounds the gain, and most are told apart
/// without looking that way up.
LocalSearch::Move LocalSearch::BestForwards(const ArrayTour& tour, const CostTable& costs,
                                            const Neighbours& neighbours, TourNode a) {
  Move best;
  const TourNode a1 = tour.Next(a);
  const auto to = neighbours.Out(a);
  const auto to_cost = neighbours.OutCosts(a);
  for (std::size_t i = 0; i < to.size(); ++i) {
    const float gain1 = tour.CostOut(a) - to_cost[i];
    if (gain1 <= 0) {
      break;
    }
    const TourNode b1 = to[i];
    if (b1 == a1) {
      continue;
    }
    const TourNode b = tour.Previous(b1);
    const int to_b1 = tour.Steps(a, b1);
    const float gain2 = gain1 + tour.CostOut(b);
    const auto next = neighbours.Out(b);
    const auto next_cost = neighbours.OutCosts(b);
    for (std::size_t k = 0; k < next.size() && gain2 > next_cost[k]; ++k) {
      const TourNode c1 = next[k];
      const TourNode c = tour.Previous(c1);
      const float bound = gain2 - next_cost[k] + tour.CostOut(c);
      if (bound > best.gain && c1 != b1 && c != a && tour.Steps(a, c) >= to_b1) {
        best.Keep({Kind::kExchange, bound - costs(c, a1), a, b, c});
      }
    }
    if (costs.symmetric()) {
      const float bound = gain1 + tour.CostOut(b1);
      if (bound > best.gain) {
        best.Keep({Kind::kTurn, bound - costs(a1, tour.Next(b1)), a, a, b1});
      }
    }
  }
  return best;
}

/// The mirror image: leaves a→a', takes c→a', leaves c→c', takes b→c', leaves b→b', closes a→b'.
LocalSearch::Move LocalSearch::BestBackwards(const ArrayTour& tour, const CostTable& costs,
                                             const Neighbours& neighbours, TourNode a1) {
  Move best;
  const TourNode a = tour.Previous(a1);
  for (const TourNode c : neighbours.In(a1)) {
    const float gain1 = tour.CostOut(a) - costs(c, a1);
    if (gain1 <= 0) {
      break;
    }
    if (c == a) {
      continue;
    }
    const TourNode c1 = tour.Next(c);
    const int to_c = tour.Steps(a, c);
    const float gain2 = gain1 + tour.CostOut(c);
    for (const TourNode b : neighbours.In(c1)) {
      const float gain3 = gain2 - costs(b, c1);
      if (gain3 <= 0) {
        break;
      }
      const int to_b = tour.Steps(a, b);
      const float bound = gain3 + tour.CostOut(b);
      if (bound > best.gain && 1 <= to_b && to_b < to_c) {
        best.Keep({Kind::kExchange, bound - costs(a, tour.Next(b)), a, b, c});
      }
    }
    if (costs.symmetric() && c != a1) {
      const TourNode before = tour.Previous(c);
      const float bound = gain1 + tour.CostOut(before);
      if (bound > best.gain && before != a1) {
        best.Keep({Kind::kTurn, bound - costs(before, a), before, before, a});
      }
    }
  }
  return best;
}

/// Makes the exchange and queues where it cut. @returns the gain; not > 0, and nothing made, where
/// it was rounding
double LocalSearch::Apply(const Move& move, ArrayTour& tour, const CostTable& costs) {
  const auto [kind, found, a, b, c] = move;
  const TourNode a1 = tour.Next(a);
  const TourNode b1 = tour.Next(b);
  const TourNode c1 = tour.Next(c);
  double gain = static_cast<double>(tour.CostOut(a)) + tour.CostOut(c);
  if (kind == Kind::kExchange) {
    gain += static_cast<double>(tour.CostOut(b)) - costs(a, b1) - costs(b, c1) - costs(c, a1);
  } else {
    gain -= static_cast<double>(costs(a, c)) + costs(a1, c1);
  }
  if (!(gain > 1e-6 * found)) {
    return 0;
  }
  if (kind == Kind::kExchange) {
    tour.ExchangePieces(a, b, c, costs);
    Push(b);
    Push(b1);
  } else {
    tour.TurnPiece(a, c, costs);
  }
  Push(a);
  Push(a1);
  Push(c);
  Push(c1);
  return gain;
}

double LocalSearch::Descend(ArrayTour& tour, const CostTable& costs, const Neighbours& neighbours,
                            TourClock& clock) {
  double gained = 0;
  while (count_ > 0 && !clock.Late()) {
    const TourNode node = Pop();
    Move best = BestForwards(tour, costs, neighbours, node);
    best.Keep(BestBackwards(tour, costs, neighbours, node));
    if (best.kind != Kind::kNone) {
      gained += Apply(best, tour, costs);
    }
  }
  return gained;
}

std::size_t LocalSearch::MemoryBytes() const {
  return queue_.capacity() * sizeof(TourNode) + queued_.capacity();
}

}  // namespace pipewright
