// SPDX-License-Identifier: MIT
#pragma once

#include "plan/motion/surroundings.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/robot.h"
#include "platform/robot/shapes.h"

namespace pipewright {

/// Distances that a planned configuration keeps. Each is what the controller keeps, plus room for
/// its tracking error, so that what is planned can be followed.
struct CollisionConfig {
  double margin_m = 0.04;         ///< shapes as built to obstacle voxels
  double sphere_margin_m = 0.03;  ///< the controller's spheres to obstacle voxels and pipes
  double self_margin_m = 0.02;    ///< between the robot's own bodies
  double plane_m = 0.11;          ///< sphere centres to planes: Table I's 0.1 m and a little
  double pipe_m = 0.085;          ///< sphere centres to pipe surfaces: Table I's 0.075 m likewise
  double plane_border_m = 0.10;   ///< a plane counts this far beyond its seen rectangle
  double pipe_border_m = 0.05;    ///< likewise a pipe beyond its seen ends
  double base_plane_m = 0.51;     ///< base centre to upright planes: Table I's 0.5 m and a little
  double base_margin_m = 0.03;    ///< base discs to obstacle columns
  double joint_margin_rad = 0.03;
};

constexpr bool Valid(const CollisionConfig& c) {
  return 0 < c.sphere_margin_m && c.sphere_margin_m <= c.margin_m && 0 <= c.self_margin_m &&
         0 < c.plane_m && 0 < c.pipe_m && 0 <= c.plane_border_m && 0 <= c.pipe_border_m &&
         0 <= c.base_plane_m && 0 <= c.base_margin_m && 0 <= c.joint_margin_rad;
}

/// Says whether the robot may stand in a configuration: away from obstacles (occupied voxels, and
/// unknown ones that the robot has not swept), from the scene's planes and pipes and from itself,
/// within its joints' limits. Planes that lie flat do not concern the base.
///
/// Broad phase: the body's spheres in the distance field. Where a sphere is between sphere_margin_m
/// and margin_m, the shapes as built decide, by libccd's MPR against the voxels' boxes: no heap.
///
/// @cost see tests/bench/motion_bench.cc
class CollisionChecker {
 public:
  explicit CollisionChecker(const Surroundings& around, const CollisionConfig& config = {});

  bool Free(const Configuration& q) const;

  /// The smallest distance of the body's spheres and discs to obstacle voxels and pipes; a lower
  /// bound of the robot's own distance, negative where they overlap.
  double Clearance(const Configuration& q) const;

  /// The whole edge is free, checked at least every 0.02 m and 0.05 rad; not its start.
  bool FreeEdge(const Configuration& a, const Configuration& b) const;

  /// A checker whose distances are lowered, each kind for itself, to what q has, but not below
  /// floor_m: with it a robot that stopped a little inside the margins can move out again.
  CollisionChecker RelaxedTo(const Configuration& q, double floor_m = 0.005) const;

  const CollisionConfig& config() const { return config_; }
  const Surroundings& around() const { return around_; }

 private:
  using Body = Kinematics<kArmJoints>;

  bool WithinJointLimits(const Configuration& q) const;
  bool BaseFree(const Configuration& q) const;
  bool SpheresFree(const Body& body) const;
  bool SphereFreeOfScene(const Vector3d& p_W, double r_m) const;
  bool ShapesFree(const Body& body, int of_body) const;
  bool SelfFree(const Body& body) const;

  Surroundings around_;
  CollisionConfig config_;
};

}  // namespace pipewright
