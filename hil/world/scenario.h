// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hil/world/conditions.h"
#include "hil/world/solid.h"
#include "platform/core/frames.h"

namespace pipewright::hil {

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

/// A world, a robot's start in it, and how its devices do there. The format is documented in
/// hil/world/scenarios/pipes3.toml.
///
///   name, description      text; name is required
///   [workspace]            min_m max_m: W, what is to be inspected                     required
///   [map]                  lo_m hi_m: what the map stores   (W + 0.5 m and the start + 0.6 m,
///                          z from -0.1 m)
///   [start]                x_m y_m yaw_rad, joints_rad[7] (home), clearance_m (0.15)    required
///   [[plane]]              name normal offset_m, ground (false); free where normal'p > offset
///   [[box]]                name center_m size_m, rpy_rad (0 0 0)
///   [[cylinder]]           name from_m to_m radius_m
///   [[mesh]]               name file, scale (1), position_m (0 0 0), rpy_rad (0 0 0)
///   [camera]               the fields of CameraSpec
///   [base]                 the fields of BaseSpec
///   [[fault]]              device kind at_s (0), for slip also for_s left (0) right (0)
struct Scenario : Conditions {
  std::string name;
  std::string description;
  BoxRegion workspace;
  BoxRegion map;
  StartPose start;
  std::vector<Solid> solids;  ///< planes, boxes, cylinders, meshes; each in the order of the file
};

/// The voxels of a region: floor(coordinate / 0.05 m), both ends included.
struct VoxelRange {
  std::array<int, 3> lo{};
  std::array<int, 3> hi{};
};
VoxelRange VoxelsOf(const BoxRegion& region);

/// A scenario, or everything that is wrong with it, one line each: "file:line:column: key: what".
struct ScenarioResult {
  std::optional<Scenario> scenario;
  std::vector<std::string> errors;
};

/// @param origin     the name in error messages
/// @param directory  where relative mesh files are looked for
ScenarioResult ParseScenario(std::string_view toml, const std::string& origin,
                             const std::string& directory);

/// A shipped scenario by its name, else a file.
ScenarioResult LoadScenario(const std::string& name_or_file);

const std::vector<ShippedToml>& ShippedScenarios();

}  // namespace pipewright::hil
