// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "plan/tour/cost_table.h"

namespace pipewright {

/// Of every node, the few to which, and from which, a way is cheapest: where a search looks first.
class Neighbours {
 public:
  static constexpr int kMost = 8;

  explicit Neighbours(int node_capacity);

  /// Of the costs as they are (reduced, see Assignment), cheapest first. O(n²)
  void Find(const CostTable& costs);

  std::span<const TourNode> Out(int node) const { return {&out_[At(node)], count_}; }
  /// What the way to each of Out(node) costs.
  std::span<const float> OutCosts(int node) const { return {&out_costs_[At(node)], count_}; }
  std::span<const TourNode> In(int node) const { return {&in_[At(node)], count_}; }

  std::size_t MemoryBytes() const;

 private:
  static std::size_t At(int node) { return static_cast<std::size_t>(node) * kMost; }

  std::size_t count_ = 0;
  std::vector<TourNode> out_;
  std::vector<float> out_costs_;
  std::vector<TourNode> in_;
};

}  // namespace pipewright
