// SPDX-License-Identifier: MIT
#include "plan/motion/rrt_connect.h"

#include <algorithm>
#include <numbers>

#include "plan/motion/edge.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

/// Cheap stand-in for an edge's time, to choose neighbours. [s^2]
double Apart(const Configuration& a, const Configuration& b, const EdgeSpeeds& speeds) {
  const double turn_s = WrapAngle(a(2) - b(2)) / speeds.turn_radps;
  return (a.head<2>() - b.head<2>()).squaredNorm() / (speeds.drive_mps * speeds.drive_mps) +
         turn_s * turn_s +
         (a.tail<kArmJoints>() - b.tail<kArmJoints>())
             .cwiseQuotient(speeds.joint_radps)
             .squaredNorm();
}

/// Where to grow next: the base within the box of both ends and some more, the joints about both
/// ends within their limits; often in the home posture.
Configuration Sample(const Configuration& from, const Configuration& to, bool arm_only, Rng& rng) {
  constexpr double kAround_m = 0.5;
  constexpr double kAround_rad = 1.5;
  constexpr double kHomeShare = 0.25;
  Configuration q = from;
  if (!arm_only) {
    for (int i = 0; i < 2; ++i) {
      q(i) = rng.Uniform(std::min(from(i), to(i)) - kAround_m,  //
                         std::max(from(i), to(i)) + kAround_m);
    }
    q(2) = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  }
  const bool home = rng.Uniform() < kHomeShare;
  for (int i = 0; i < kArmJoints; ++i) {
    const ArmJoint& joint = TracerUf7().arm.joints[i];
    const double lo = std::min(from(3 + i), to(3 + i)) - kAround_rad;
    const double hi = std::max(from(3 + i), to(3 + i)) + kAround_rad;
    q(3 + i) = home ? TracerUf7().home_rad[i]
                    : rng.Uniform(std::max(lo, joint.q_min_rad), std::min(hi, joint.q_max_rad));
  }
  return q;
}

}  // namespace

RrtConnect::RrtConnect(int node_capacity, double reach_m, double reach_rad)
    : node_capacity_(node_capacity), reach_m_(reach_m), reach_rad_(reach_rad) {
  from_.reserve(node_capacity);
  to_.reserve(node_capacity);
}

bool RrtConnect::Add(Tree& tree, const Configuration& q, int parent) const {
  if (static_cast<int>(tree.size()) == node_capacity_) {
    return false;
  }
  tree.push_back({q, parent});
  return true;
}

/// As far from a to b as one extension goes; b itself when that is within reach.
Configuration RrtConnect::Towards(const Configuration& a, const Configuration& b) const {
  constexpr double kNothing = 1e-9;
  const Edge edge(a, b, SpeedsOf(TracerUf7()));
  const double s = std::min({1.0, reach_m_ / std::max(edge.drive_m(), kNothing),
                             reach_rad_ / std::max(edge.turn_rad(), kNothing),
                             reach_rad_ / std::max(edge.joints_rad(), kNothing)});
  return s == 1.0 ? b : edge.At(s);
}

/// Extends the tree from its nearest node to q, one extension after the other, while it can.
/// @returns kOk: q is the tree's last node; kInfeasible: blocked; kFull
Status RrtConnect::Connect(const CollisionChecker& checker, Tree& tree,
                           const Configuration& q) const {
  const EdgeSpeeds speeds = SpeedsOf(TracerUf7());
  int at = 0;
  double least = Apart(tree[0].q, q, speeds);
  for (int i = 1; i < static_cast<int>(tree.size()); ++i) {
    const double apart = Apart(tree[i].q, q, speeds);
    if (apart < least) {
      least = apart;
      at = i;
    }
  }
  while (true) {  // ends: every round adds a node
    const Configuration next = Towards(tree[at].q, q);
    if (!checker.FreeEdge(tree[at].q, next)) {
      return Status::kInfeasible;
    }
    if (!Add(tree, next, at)) {
      return Status::kFull;
    }
    if (next == q) {
      return Status::kOk;
    }
    at = static_cast<int>(tree.size()) - 1;
  }
}

/// The way from the root of from_ over the last nodes of both, which are the same, to to_'s root.
void RrtConnect::Join(std::vector<Configuration>& way) const {
  way.clear();
  for (int i = static_cast<int>(from_.size()) - 1; i >= 0; i = from_[i].parent) {
    way.push_back(from_[i].q);
  }
  std::reverse(way.begin(), way.end());
  for (int i = to_.back().parent; i >= 0; i = to_[i].parent) {
    way.push_back(to_[i].q);
  }
}

Status RrtConnect::Search(const CollisionChecker& checker, const Configuration& from,
                          const Configuration& to, bool arm_only, int iterations, Rng& rng,
                          std::vector<Configuration>& way) {
  from_.clear();
  to_.clear();
  static_cast<void>(Add(from_, from, -1));
  static_cast<void>(Add(to_, to, -1));
  for (int i = 0; i < iterations; ++i) {
    Tree& growing = i % 2 == 0 ? from_ : to_;
    Tree& other = i % 2 == 0 ? to_ : from_;
    const std::size_t before = growing.size();
    Status status = Connect(checker, growing, Sample(from, to, arm_only, rng));
    if (status != Status::kFull && growing.size() > before) {
      const Configuration reached = growing.back().q;
      status = Connect(checker, other, reached);
      if (status == Status::kOk) {
        Join(way);
        return Status::kOk;
      }
    }
    if (status == Status::kFull) {
      return Status::kFull;
    }
  }
  return Status::kIterationLimit;
}

}  // namespace pipewright
