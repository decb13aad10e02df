// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "plan/motion/surroundings.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/robot.h"
#include "platform/robot/shapes.h"

namespace pipewright {

/// Distances that a planned configuration keeps. Each is what the controller's constraints keep
/// (ctrl/constraints) and slack_m more for its tracking error and the chance constraints' buffers,
/// so that what is planned can be followed.
struct CollisionConfig {
  double margin_m = 0.04;            ///< shapes as built to obstacle voxels
  double slack_m = 0.012;            ///< added to every distance below
  double voxel_margin_m = 0.02;      ///< spheres and base discs to obstacle voxels and columns
  double primitive_margin_m = 0.03;  ///< spheres to planes and pipes
  double plane_m = 0.1;              ///< sphere centres to planes, at least: Table I
  double pipe_m = 0.075;             ///< sphere centres to pipe surfaces, at least: Table I
  double base_plane_m = 0.5;         ///< base centre to upright planes: Table I
  double self_m = 0.02;              ///< between the robot's own bodies
  double upright_nz = 0.3;           ///< |n_z| below which a plane is upright
  double plane_border_m = 0.2;       ///< a plane counts this far beyond its seen rectangle
  double plane_behind_m = 0.15;      ///< and so deep
  double pipe_border_m = 0.05;       ///< a pipe's axis counts this far beyond its seen ends
  double joint_margin_rad = 0.03;
};

constexpr bool Valid(const CollisionConfig& c) {
  return 0 < c.voxel_margin_m && 0 <= c.slack_m && c.voxel_margin_m + c.slack_m <= c.margin_m &&
         0 <= c.primitive_margin_m && 0 <= c.plane_m && 0 <= c.pipe_m && 0 <= c.base_plane_m &&
         0 <= c.self_m && 0 <= c.upright_nz && 0 <= c.plane_border_m && 0 <= c.plane_behind_m &&
         0 <= c.pipe_border_m && 0 <= c.joint_margin_rad;
}
static_assert(Valid(CollisionConfig{}));

/// Says whether the robot may stand in a configuration: away from obstacles (occupied voxels, and
/// unknown ones that the robot has not swept), from the scene's planes and pipes and from itself,
/// within its joints' limits. The base's discs mind columns of obstacles and upright planes only.
///
/// Obstacle voxels: a sphere that is nearer than voxel_margin_m + slack_m says no, for there the
/// controller would not go; spheres farther than margin_m and their slip (5 mm) say yes; between
/// the two the shapes as built decide (libccd). No heap. Cost: tests/bench/motion_bench.cc.
class CollisionChecker {
 public:
  explicit CollisionChecker(const Surroundings& around, const CollisionConfig& config = {});

  bool Free(const Configuration& q) const;

  /// The smallest distance of the body's spheres and discs to obstacle voxels and columns [m]: a
  /// lower bound of the robot's own, negative where they overlap.
  double Clearance(const Configuration& q) const;

  /// The edge is free at steps of at most 0.02 m and 0.05 rad; b is checked, a is not.
  bool FreeEdge(const Configuration& a, const Configuration& b) const;

  /// A checker that asks no more than what q has, kind by kind: with it a robot that stopped a
  /// little inside the margins can move out again, never deeper in. Shapes keep floor_m from
  /// voxels, unless q itself has less by the map; then the spheres alone are minded.
  CollisionChecker RelaxedTo(const Configuration& q, double floor_m = 0.005) const;

  const CollisionConfig& config() const { return config_; }
  const Surroundings& around() const { return around_; }

 private:
  using Body = Kinematics<kArmJoints>;
  enum Kind : std::uint8_t { kJoints, kColumns, kBasePlanes, kVoxels, kPlanes, kPipes, kSelf };
  static constexpr int kKinds = 7;
  static constexpr Kind kAllKinds[kKinds] = {kJoints, kColumns, kBasePlanes, kVoxels,
                                             kPlanes, kPipes,   kSelf};

  /// The body in a configuration, with what of it is asked of the world.
  struct Posture {
    explicit Posture(const Configuration& q);

    Body body;
    std::array<Vector3d, RobotShapes::kMaxSpheres> p_WSpheres;  ///< centres of the spheres
    Vector3d p_WMiddle = Vector3d::Zero();                      ///< a ball around all centres
    double reach_m = 0;
    double largest_r_m = 0;  ///< of the spheres
  };

  /// What a search for the least spare distance may leave out: it is exact between the two.
  struct Range {
    double too_little = -1e9;
    double enough = 1e9;
  };

  double Spare(Kind kind, const Configuration& q, const Posture& posture, const Range& range) const;
  double JointSpare(const Configuration& q) const;
  double ColumnSpare(const Body& body) const;
  double BasePlaneSpare(const Body& body) const;
  double VoxelSpare(const Posture& posture, const Range& range) const;
  double PlaneSpare(const Posture& posture, const Range& range) const;
  double PipeSpare(const Posture& posture, const Range& range) const;
  double SelfSpare(const Body& body, const Range& range) const;
  bool ShapesFree(const Posture& posture, double margin_m) const;

  Surroundings around_;
  CollisionConfig config_;
  std::array<double, kKinds> relief_{};  ///< how much less than required each kind may be
  bool shapes_decide_ = true;
};

}  // namespace pipewright
