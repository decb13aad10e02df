// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

/// The depth camera's data. Defaults: RealSense D455, 424x240, decimated by 2 on the device.
struct CameraSpec {
  int width = 212;
  int height = 120;
  double hfov_deg = 87;
  double rate_hz = 15;
  double z_min_m = 0.168;  ///< f B / 126: f = 223 px at 424x240, B = 95 mm
  double z_max_m = 6;
  /// sigma(z) = this times z^2 [m, z in m]: s / (f B) with 0.08 px subpixel noise, f = 223 px, B =
  /// 95 mm. Decimation does not lower it: neighbours share most of their matching window.
  double noise_sigma_at_1m = 3.8e-3;
  double invalid_fraction = 0.01;          ///< pixels without reading, anywhere
  double below_min_wrong_fraction = 0.02;  ///< of those nearer than z_min: wrong value, not none
  double lost_fraction = 0;                ///< of the frames: they never come
};

/// What the base's wheels do not tell; see hil/devices/wheel_slip.h.
struct BaseSpec {
  double yaw_scale_slow = 1;
  double yaw_scale_fast = 1;
  double slip = 0;
  double slip_sigma = 0;
};

enum class FaultKind : unsigned char {
  kAbsent,  ///< was never there
  kSilent,  ///< stops answering at at_s
  kSlip,    ///< the base's wheels lose grip at at_s, for for_s
};

struct ScheduledFault {
  std::string device;  ///< "tracer", "arm1" ... "arm7", "camera"
  FaultKind kind = FaultKind::kAbsent;
  double at_s = 0;
  double for_s = 0;  ///< kSlip's, as what follows: the share of its travel that each wheel loses
  double left = 0;
  double right = 0;
};

/// A world and a robot's start in it. The format is documented in hil/world/scenarios/pipes3.toml.
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
struct Scenario {
  std::string name;
  std::string description;
  BoxRegion workspace;
  BoxRegion map;
  StartPose start;
  std::vector<Solid> solids;  ///< planes, boxes, cylinders, meshes; each in the order of the file
  CameraSpec camera;
  BaseSpec base;
  std::vector<ScheduledFault> faults;
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

/// Names and texts of the scenarios in the binary.
struct ShippedScenario {
  std::string_view name;
  std::string_view toml;
};
const std::vector<ShippedScenario>& ShippedScenarios();

}  // namespace pipewright::hil
