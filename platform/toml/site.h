// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>
#include <vector>

#include "platform/core/frames.h"

namespace pipewright {

class TomlTable;

inline constexpr double kVoxelWidth_m = 0.05;

/// An axis-parallel box in W [m].
struct BoxRegion {
  Vector3d min_m = Vector3d::Zero();
  Vector3d max_m = Vector3d::Zero();
};

/// Where the robot stands when it is switched on.
struct StartPose {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
  std::vector<double> joints_rad;  ///< empty: the robot's own home posture
  double clearance_m = 0.15;  ///< the operator's word: nothing is nearer to the robot than this
  std::string where;          ///< "file:line:column: start", for messages
};

/// What an operator says of a place before the robot has seen any of it. Scenarios and the robot's
/// own configuration have it in the same tables:
///
///   [workspace]            min_m max_m: W, what is to be inspected                     required
///   [map]                  lo_m hi_m: what the map stores   (W + 0.5 m and the start + 0.6 m,
///                          z from -0.1 m)
///   [start]                x_m y_m yaw_rad, joints_rad[7] (home), clearance_m (0.15)    required
struct Site {
  BoxRegion workspace;
  BoxRegion map;
  StartPose start;
};

/// The three tables. What is wrong goes to the root's errors; it is not Finish()ed here.
void ReadSite(TomlTable& root, Site& site);

/// The voxels of a region: floor(coordinate / 0.05 m), both ends included.
struct VoxelRange {
  std::array<int, 3> lo{};
  std::array<int, 3> hi{};
};
VoxelRange VoxelsOf(const BoxRegion& region);

}  // namespace pipewright
