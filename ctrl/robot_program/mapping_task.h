// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include "ctrl/robot_program/perceived.h"
#include "perception/cloud/cloud.h"
#include "perception/cloud/noise_meter.h"
#include "perception/localization/scan_localizer.h"
#include "perception/map/voxel_grid.h"
#include "perception/primitives/tracker.h"
#include "platform/core/latest.h"
#include "platform/robot/model.h"

namespace pipewright {

struct MappingConfig {
  MapConfig map;
  CloudConfig cloud{.stride = 2};
  NoiseMeterConfig noise;  ///< of the camera: primitives and localization take what is measured
  PrimitiveConfig primitives;
  ScanLocalizerConfig localization;
  bool localize = false;     ///< frames are placed where they find themselves
  double max_range_m = 3.0;  ///< of a reading that enters the map
  double probe_radius_m = 0.4;
  double start_clearance_m =
      0.15;  ///< the operator's word: nothing is nearer to the robot at start
  Duration max_extrapolation = std::chrono::milliseconds(30);  ///< of the state to a frame's stamp
  std::uint64_t seed = 1;
};

struct MappingCounters {
  std::uint64_t frames = 0;        ///< received
  std::uint64_t without_pose = 0;  ///< dropped: no state of that instant
  std::uint64_t doubted = 0;       ///< not added to the map
  std::uint64_t refused = 0;       ///< dropped: the frame made no sense
  CloudCounts cloud;               ///< readings left out
};

/// The second of the three tasks: sensor frames -> map, primitives, distances, coverage.
/// No heap after construction.
class MappingTask {
 public:
  MappingTask(const MappingConfig& config, const RobotModel<kArmJoints>& robot);

  /// The robot stands at q when it is switched on: its own bodies, and the operator's clearance
  /// about them, hold no obstacle.
  void Start(const Configuration& q);

  /// One frame, placed where it finds itself among what was seen before, else where `motion` has
  /// the robot at its stamp. A frame whose pose is not known is dropped and counted; one whose pose
  /// is in doubt may give a fix, but changes no map.
  Status Step(const DepthFrame& frame, const Motion& motion);

  /// What the probe covers at q. Each frame does this for its own instant.
  int Cover(const Configuration& q);

  void DeclareResidual(const ResidualVoxels& residual);

  const VoxelGrid& map() const { return map_; }
  const DistanceField& field() const { return field_; }
  const Scene& scene() const { return tracker_.scene(); }
  /// Where the last frame found the base, if it did.
  const std::optional<PoseFix>& fix() const { return fix_; }
  const ScanLocalizer& localizer() const { return localizer_; }
  const NoiseMeter& noise() const { return noise_; }
  const MappingCounters& counters() const { return counters_; }

 private:
  bool Localize(const Isometry3d& X_BS, const Motion& motion, Configuration& q);

  MappingConfig config_;
  const RobotModel<kArmJoints>& robot_;
  VoxelGrid map_;
  DistanceField field_;
  NoiseMeter noise_;
  PrimitiveTracker tracker_;
  ScanLocalizer localizer_;
  std::optional<PoseFix> fix_;
  Cloud cloud_;
  std::array<Eigen::Vector3f, Cloud::kMaxPoints> points_W_{};
  MappingCounters counters_;
};

}  // namespace pipewright
