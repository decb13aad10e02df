// SPDX-License-Identifier: MIT
#include "plan/tour/neighbours.h"

#include <algorithm>
#include <limits>

namespace pipewright {
namespace {

constexpr TourNode kNobody = -1;

/// Puts `node` into its place among the `count` cheapest in `best`, the dearest of which falls out.
template <typename CostOf>
void Insert(TourNode* best, std::size_t count, int node, CostOf cost_of) {
  const float cost = cost_of(node);
  std::size_t k = count - 1;
  if (best[k] != kNobody && cost_of(best[k]) <= cost) {
    return;
  }
  for (; k > 0 && (best[k - 1] == kNobody || cost_of(best[k - 1]) > cost); --k) {
    best[k] = best[k - 1];
  }
  best[k] = static_cast<TourNode>(node);
}

}  // namespace

Neighbours::Neighbours(int node_capacity)
    : out_(At(node_capacity)), out_costs_(At(node_capacity)), in_(At(node_capacity)) {}

void Neighbours::Find(const CostTable& costs) {
  const int n = costs.size();
  count_ = static_cast<std::size_t>(std::min(kMost, n - 1));
  std::fill(out_.begin(), out_.end(), kNobody);
  std::fill(in_.begin(), in_.end(), kNobody);
  for (int i = 0; i < n; ++i) {  // a row at a time, which lies together in memory
    for (int j = 0; j < n; ++j) {
      if (i != j) {
        Insert(&out_[At(i)], count_, j, [&](int to) { return costs(i, to); });
        Insert(&in_[At(j)], count_, i, [&](int from) { return costs(from, j); });
      }
    }
    for (std::size_t k = 0; k < count_; ++k) {
      out_costs_[At(i) + k] = costs(i, out_[At(i) + k]);
    }
  }
}

std::size_t Neighbours::MemoryBytes() const {
  return (out_.capacity() + in_.capacity()) * sizeof(TourNode) +
         out_costs_.capacity() * sizeof(float);
}

}  // namespace pipewright
