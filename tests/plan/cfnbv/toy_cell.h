// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "perception/scene.h"
#include "plan/goal.h"
#include "platform/robot/robot.h"

namespace pipewright::test {

struct ToyPipe {
  Vector3d p_W;
  Vector3d l_W;  ///< |l| = 1
  double length_m;
  double radius_m;
};

/// A 1.5 m cell in a hall, open at x = 0 and above, as the planner meets it: pipes before three
/// walls, seen by a camera without noise, and a robot that follows paths exactly.
class ToyCell {
 public:
  explicit ToyCell(std::vector<ToyPipe> pipes);

  static MapConfig Config();
  static std::vector<ToyPipe> ThreePipes();
  static Configuration StartPose();

  /// The operator's word at the start: no obstacle within this of the robot's body.
  void Begin(const Configuration& q, double clearance_m);

  /// One frame from q: insert, sweep the body, cover, rebuild the field.
  void Look(const Configuration& q);

  /// Follows the path to its end, looking about ten times a second. @returns seconds taken
  double Follow(const Goal& goal, Configuration& q,
                const std::function<void(const Configuration&)>& visit = {});

  /// Share of W's voxels that hold true pipe surface of which the probe has truly seen some.
  double TruthCoverage() const;
  std::vector<int> Missed() const;  ///< the others, as indices of the map

  VoxelGrid map;
  DistanceField field;
  Scene scene;

 private:
  double Cast(const Vector3d& origin, const Vector3d& direction, int* pipe = nullptr) const;
  void See(int pipe, const Vector3d& p_W);
  void Sweep(const Configuration& q, double inflate_m);
  void CoverTruth(const Vector3d& p_WP);

  std::vector<ToyPipe> pipes_;
  std::vector<int> estimate_;      ///< of a pipe in the scene; -1: not seen yet
  std::vector<Vector3d> surface_;  ///< a sample point each
  std::vector<int> surface_voxel_;
  std::vector<char> covered_;  ///< by voxel of the map
};

}  // namespace pipewright::test
