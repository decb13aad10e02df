// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "plan/tour/cost_table.h"

namespace pipewright {

/// The best tour itself, by dynamic programming over sets of nodes:
///
///   best(S, j) = min over k in S \ {j} of best(S \ {j}, k) + c(k, j),   best({j}, j) = c(base, j)
///
/// where a path leaves the base, visits S and ends at j. [Held, Karp: A dynamic programming
/// approach to sequencing problems, J. SIAM 10, 1962]
struct HeldKarp {
  static constexpr int kNodesMax = 13;  ///< of the table: the dummy is one
  /// Of memory beside the table, for the most nodes.
  static constexpr int kFloats = (1 << (kNodesMax - 1)) * (kNodesMax - 1);

  /// Puts the best tour of 2 to kNodesMax nodes into `order`, from the last node on. Sums are of
  /// float. O(n² 2ⁿ): about a millisecond for 13
  static void Solve(const CostTable& costs, std::span<float> memory, std::span<TourNode> order);
};

}  // namespace pipewright
