// SPDX-License-Identifier: MIT
#include "plan/tour/subtours.h"

#include <algorithm>

namespace pipewright {

Subtours::Subtours(int node_capacity)
    : next_(node_capacity),
      previous_(node_capacity),
      cost_out_(node_capacity),
      tour_of_(node_capacity),
      first_(node_capacity / 2),
      length_(node_capacity / 2) {}

void Subtours::Assign(std::span<const TourNode> next, std::span<const TourNode> previous,
                      std::span<const float> cost_out) {
  n_ = static_cast<int>(next.size());
  std::copy(next.begin(), next.end(), next_.begin());
  std::copy(previous.begin(), previous.end(), previous_.begin());
  std::copy(cost_out.begin(), cost_out.end(), cost_out_.begin());
}

void Subtours::Assign(std::span<const TourNode> next, const CostTable& costs) {
  n_ = static_cast<int>(next.size());
  for (int a = 0; a < n_; ++a) {
    SetNext(static_cast<TourNode>(a), next[a], costs(a, next[a]));
  }
}

void Subtours::SetNext(TourNode a, TourNode b, float cost) {
  next_[a] = b;
  previous_[b] = a;
  cost_out_[a] = cost;
}

void Subtours::Label() {
  constexpr TourNode kNone = -1;
  std::fill_n(tour_of_.begin(), n_, kNone);
  count_ = 0;
  for (int a = 0; a < n_; ++a) {
    if (tour_of_[a] != kNone) {
      continue;
    }
    TourNode length = 0;
    for (int x = a; tour_of_[x] == kNone; x = next_[x]) {
      tour_of_[x] = static_cast<TourNode>(count_);
      ++length;
    }
    first_[count_] = static_cast<TourNode>(a);
    length_[count_++] = length;
  }
}

int Subtours::Smallest() const {
  int smallest = -1;
  for (int t = 0; t < count_; ++t) {
    if (length_[t] > 0 && (smallest < 0 || length_[t] < length_[smallest])) {
      smallest = t;
    }
  }
  return smallest;
}

/// Reduced costs are not negative: a joint whose gain would not do even if its last way were free
/// is passed by without looking that way up.
Subtours::Joint Subtours::BestJoint(int tour, const CostTable& costs,
                                    const Neighbours& neighbours) const {
  Joint best{.gain = -costs.Forbidden() / 2};
  TourNode u = first_[tour];
  for (int k = 0; k < length_[tour]; ++k, u = next_[u]) {
    const TourNode u1 = next_[u];
    const auto to = neighbours.Out(u);
    const auto to_cost = neighbours.OutCosts(u);
    for (std::size_t i = 0; i < to.size(); ++i) {
      const TourNode v = previous_[to[i]];
      const float bound = cost_out_[u] - to_cost[i] + cost_out_[v];
      if (bound > best.gain && tour_of_[v] != tour && bound - costs(v, u1) > best.gain) {
        best = {u, v, bound - costs(v, u1)};
      }
    }
    for (const TourNode v : neighbours.In(u1)) {
      const float bound = cost_out_[u] + cost_out_[v];
      if (bound > best.gain && tour_of_[v] != tour) {
        const float gain = bound - costs(v, u1) - costs(u, next_[v]);
        best = gain > best.gain ? Joint{u, v, gain} : best;
      }
    }
  }
  return best;
}

void Subtours::Apply(int tour, const Joint& joint, const CostTable& costs) {
  const auto [u, v, gain] = joint;
  const TourNode other = tour_of_[v];
  for (TourNode k = 0, x = u; k < length_[tour]; ++k, x = next_[x]) {
    tour_of_[x] = other;
  }
  length_[other] = static_cast<TourNode>(length_[other] + length_[tour]);
  length_[tour] = 0;
  const TourNode u1 = next_[u];
  const TourNode v1 = next_[v];
  SetNext(u, v1, costs(u, v1));
  SetNext(v, u1, costs(v, u1));
}

bool Subtours::Join(const CostTable& costs, const Neighbours& neighbours) {
  Label();
  for (int left = count_; left > 1; --left) {
    const int tour = Smallest();
    const Joint joint = BestJoint(tour, costs, neighbours);
    if (joint.u < 0) {
      return false;
    }
    Apply(tour, joint, costs);
  }
  return true;
}

void Subtours::CopyOrder(std::span<TourNode> order) const {
  TourNode x = 0;
  for (int k = 0; k < n_; ++k) {
    order[k] = x;
    x = next_[x];
  }
}

std::size_t Subtours::MemoryBytes() const {
  return (3 * next_.capacity() + 2 * first_.capacity()) * sizeof(TourNode) +
         cost_out_.capacity() * sizeof(float);
}

}  // namespace pipewright
