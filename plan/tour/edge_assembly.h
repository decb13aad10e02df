// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "plan/tour/cost_table.h"
#include "plan/tour/neighbours.h"
#include "plan/tour/subtours.h"

namespace pipewright {

/// Children of two tours, A with a few of B's ways: edge assembly crossover for tours that have a
/// direction.
///
/// Follow a way of A forwards, then the way of B that ends there backwards, and so on: this closes
/// to an AB-cycle. Where A and B differ, each node leads out of exactly one, so that the cycles are
/// unique. Taking B's ways in place of A's along one of them leaves a permutation, whose parts
/// Subtours joins. [Nagata: Edge assembly crossover for the asymmetric travelling salesman problem:
/// IJCAI 2006 workshop; Nagata, Kobayashi: A powerful genetic algorithm using edge assembly
/// crossover for the TSP, INFORMS J. Comput. 25, 2013]
class EdgeAssembly {
 public:
  explicit EdgeAssembly(int node_capacity);

  /// Takes the parents. O(n) @returns the number of AB-cycles: 0 where they are the same tour
  int Begin(std::span<const TourNode> a, std::span<const TourNode> b, const CostTable& costs);

  /// The child by cycle k. O(n) @returns false where its parts cannot be joined
  bool MakeChild(int k, const CostTable& costs, const Neighbours& neighbours);
  /// The child of no parents: the parts of a permutation joined. @returns as MakeChild()
  bool JoinParts(std::span<const TourNode> next, const CostTable& costs,
                 const Neighbours& neighbours);
  const Subtours& child() const { return child_; }
  /// Whether the child leaves `node` by another way than A.
  bool Differs(int node) const { return child_.Next(node) != a_.next[node]; }

  std::size_t MemoryBytes() const;

 private:
  struct Links {
    std::vector<TourNode> next, previous;

    explicit Links(int node_capacity) : next(node_capacity), previous(node_capacity) {}
    void Assign(std::span<const TourNode> order);
  };

  Links a_;
  Links b_;
  std::vector<float> a_cost_out_;
  std::vector<TourNode> on_cycle_;  // the nodes that leave by A's ways, cycle by cycle
  std::vector<TourNode> begin_;     // of cycle k, of 2 or more, in on_cycle_; and the end
  std::vector<std::uint8_t> seen_;
  Subtours child_;
};

}  // namespace pipewright
