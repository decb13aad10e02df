// SPDX-License-Identifier: MIT
#include "plan/tour/array_tour.h"

#include <algorithm>

namespace pipewright {

ArrayTour::ArrayTour(int node_capacity)
    : order_(node_capacity),
      place_(node_capacity),
      moved_(node_capacity),
      cost_out_(node_capacity) {}

void ArrayTour::Assign(std::span<const TourNode> order, const CostTable& costs) {
  n_ = static_cast<int>(order.size());
  for (int p = 0; p < n_; ++p) {
    Put(p, order[p]);
    cost_out_[order[p]] = costs(order[p], order[Wrapped(p + 1)]);
  }
}

void ArrayTour::Assign(std::span<const TourNode> order, std::span<const float> cost_out) {
  n_ = static_cast<int>(order.size());
  for (int p = 0; p < n_; ++p) {
    Put(p, order[p]);
  }
  std::copy(cost_out.begin(), cost_out.end(), cost_out_.begin());
}

double ArrayTour::Length() const {
  double sum = 0;
  for (int a = 0; a < n_; ++a) {
    sum += cost_out_[a];
  }
  return sum;
}

void ArrayTour::ExchangePieces(TourNode a, TourNode b, TourNode c, const CostTable& costs) {
  const TourNode a1 = Next(a);
  const TourNode b1 = Next(b);
  const TourNode c1 = Next(c);
  // Round a circle, exchanging any two of the three pieces is the same; the longest stays.
  const int ab = Steps(a, b);
  const int bc = Steps(b, c);
  const int ca = n_ - ab - bc;
  if (ca >= ab && ca >= bc) {
    ExchangeAt(place_[a1], ab, bc);
  } else if (ab >= bc) {
    ExchangeAt(place_[b1], bc, ca);
  } else {
    ExchangeAt(place_[c1], ca, ab);
  }
  cost_out_[a] = costs(a, b1);
  cost_out_[b] = costs(b, c1);
  cost_out_[c] = costs(c, a1);
}

/// Exchanges two pieces that follow each other from `place` on, of so many nodes.
void ArrayTour::ExchangeAt(int place, int first, int second) {
  for (int k = 0, p = place; k < first; ++k, p = Wrapped(p + 1)) {
    moved_[k] = order_[p];
  }
  int to = place;
  for (int k = 0, p = Wrapped(place + first); k < second; ++k, p = Wrapped(p + 1)) {
    Put(to, order_[p]);
    to = Wrapped(to + 1);
  }
  for (int k = 0; k < first; ++k) {
    Put(to, moved_[k]);
    to = Wrapped(to + 1);
  }
}

void ArrayTour::TurnPiece(TourNode a, TourNode c, const CostTable& costs) {
  const int inside = Steps(a, c);
  if (2 * inside <= n_) {
    TurnAt(place_[Next(a)], inside, costs);
  } else {
    TurnAt(place_[Next(c)], n_ - inside, costs);
  }
}

void ArrayTour::TurnAt(int place, int count, const CostTable& costs) {
  const TourNode before = order_[place == 0 ? n_ - 1 : place - 1];
  const TourNode first = order_[place];
  const TourNode last = order_[Wrapped(place + count - 1)];
  const TourNode after = Next(last);
  for (int k = 1, p = Wrapped(place + count - 1); k < count;
       ++k) {  // the way in is the way out now
    const int previous = p == 0 ? n_ - 1 : p - 1;
    cost_out_[order_[p]] = cost_out_[order_[previous]];
    p = previous;
  }
  for (int k = 0, i = place, j = Wrapped(place + count - 1); k < count / 2; ++k) {
    const TourNode at_i = order_[i];
    Put(i, order_[j]);
    Put(j, at_i);
    i = Wrapped(i + 1);
    j = j == 0 ? n_ - 1 : j - 1;
  }
  cost_out_[before] = costs(before, last);
  cost_out_[first] = costs(first, after);
}

std::size_t ArrayTour::MemoryBytes() const {
  return 3 * order_.capacity() * sizeof(TourNode) + cost_out_.capacity() * sizeof(float);
}

}  // namespace pipewright
