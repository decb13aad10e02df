// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "plan/tour/cost_table.h"
#include "plan/tour/neighbours.h"

namespace pipewright {

/// Closed tours that together visit every node once, and how to make one of them.
class Subtours {
 public:
  explicit Subtours(int node_capacity);

  /// Every node's successor: any permutation without fixed points, and what each way costs.
  void Assign(std::span<const TourNode> next, std::span<const TourNode> previous,
              std::span<const float> cost_out);
  void Assign(std::span<const TourNode> next, const CostTable& costs);
  void SetNext(TourNode a, TourNode b, float cost);

  TourNode Next(int a) const { return next_[a]; }

  /// Joins the smallest with another, until one is left, each time where it costs least among the
  /// ways of the neighbour lists:  u→u', v→v'  become  u→v', v→u'. [Karp: A patching algorithm for
  /// the nonsymmetric travelling-salesman problem, SIAM J. Comput. 8, 1979]
  /// @returns whether one is left: no, where no listed way leads out of one, or only by breaking an
  ///   end (CostTable::Forbidden)
  bool Join(const CostTable& costs, const Neighbours& neighbours);

  /// After Join().
  void CopyOrder(std::span<TourNode> order) const;
  std::span<const float> cost_out() const {
    return {cost_out_.data(), static_cast<std::size_t>(n_)};
  }

  std::size_t MemoryBytes() const;

 private:
  struct Joint {
    TourNode u = -1;
    TourNode v = -1;
    float gain = 0;
  };

  void Label();
  int Smallest() const;
  Joint BestJoint(int tour, const CostTable& costs, const Neighbours& neighbours) const;
  void Apply(int tour, const Joint& joint, const CostTable& costs);

  int n_ = 0;
  int count_ = 0;
  std::vector<TourNode> next_, previous_;
  std::vector<float> cost_out_;
  std::vector<TourNode> tour_of_;         // by node
  std::vector<TourNode> first_, length_;  // by tour, of 2 nodes or more; 0: joined to another
};

}  // namespace pipewright
