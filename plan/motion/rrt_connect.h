// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "plan/motion/collision.h"
#include "platform/core/rng.h"
#include "platform/core/status.h"

namespace pipewright {

/// Two trees that grow towards each other from both ends of a way, by the edges of
/// plan/motion/edge.h. [Kuffner, LaValle: RRT-Connect, ICRA 2000, figures 2 and 5]
/// All memory is taken at construction.
class RrtConnect {
 public:
  /// node_capacity >= 2 of each tree; an extension drives at most reach_m and turns the base and
  /// every joint at most reach_rad.
  RrtConnect(int node_capacity, double reach_m, double reach_rad);

  /// Puts the waypoints from ... to into `way`, whose capacity is 2 node_capacity at least. With
  /// arm_only the base stays where it is in `from`.
  /// @returns kOk, kIterationLimit after that many samples, or kFull: a tree is
  Status Search(const CollisionChecker& checker, const Configuration& from, const Configuration& to,
                bool arm_only, int iterations, Rng& rng, std::vector<Configuration>& way);

 private:
  struct Node {
    Configuration q;
    int parent = -1;
  };
  using Tree = std::vector<Node>;  // never beyond the capacity reserved

  bool Add(Tree& tree, const Configuration& q, int parent) const;
  Configuration Towards(const Configuration& a, const Configuration& b) const;
  Status Connect(const CollisionChecker& checker, Tree& tree, const Configuration& q) const;
  void Join(std::vector<Configuration>& way) const;

  int node_capacity_;
  double reach_m_;
  double reach_rad_;
  Tree from_;
  Tree to_;
};

}  // namespace pipewright
