// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plan/tour/cost_table.h"
#include "plan/tour/neighbours.h"
#include "platform/core/rng.h"

namespace pipewright {

/// Tours to begin with: from node to node, most often to the cheapest that is left.
class Construction {
 public:
  explicit Construction(int node_capacity);

  /// A tour of all nodes of `costs`, from the dummy if there is one, else from a random node. The
  /// problem's ends are kept. O(n²) at worst
  void Build(const TourProblem& problem, const CostTable& costs, const Neighbours& neighbours,
             Rng& rng, std::span<TourNode> order);

  std::size_t MemoryBytes() const { return visited_.capacity(); }

 private:
  TourNode NextAfter(TourNode a, const CostTable& costs, const Neighbours& neighbours,
                     Rng& rng) const;

  std::vector<std::uint8_t> visited_;
};

}  // namespace pipewright
