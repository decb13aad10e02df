// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "perception/scene.h"
#include "platform/robot/state_history.h"

namespace pipewright {

/// What the control task hands to the mapping task each cycle.
struct Motion {
  StateHistory states;
  Matrix3d base_covariance = Matrix3d::Zero();  ///< of the newest state's (x, y, phi)
  Matrix3d base_worst = Matrix3d::Zero();       ///< PoseFilter::worst_covariance()
  bool base_doubted = false;                    ///< PoseFilter::doubted()
};

/// What the mapping task hands to the control task after each frame.
struct Surrounding {
  explicit Surrounding(const MapConfig& map) : field(map) {}

  Scene scene;
  DistanceField field;
};

/// What it hands to the planning task: the same, and the map they came from.
struct MapSnapshot {
  explicit MapSnapshot(const MapConfig& config) : map(config), field(config) {}

  Time stamp{};
  VoxelGrid map;
  DistanceField field;
  Scene scene;
};

/// Unknown voxels that the planner gave up, on their way back to the map.
struct ResidualVoxels {
  FixedVector<VoxelIndex, 65536> voxels;
};

}  // namespace pipewright
