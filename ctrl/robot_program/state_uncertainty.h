// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "ctrl/constraints/svfi.h"
#include "perception/localization/wheel_odometry.h"

namespace pipewright {

/// How wrong q may be against the scene and the map that the control task holds.
///
/// Not against the world: the mapping task places what the camera sees by the same odometry, so
/// that an error of the base's pose at that time moved the robot and its surroundings as one body,
/// and no distance. What matters is the error since. Of that the primitives' own covariances hold
/// the part up to the scene's stamp (PrimitiveConfig::drift, pose_sigma), voxel_noise_m the map's.
/// What is left, and is here:
///
/// - base: what the odometry's covariance grew by since the scene's stamp
///   (WheelOdometry::CovarianceSince). It goes on growing when no new scene comes.
/// - joints: the noise of their readings now, each alone. That of the time of the frame is part of
///   the camera's pose, thus of pose_sigma.
class StateUncertainty {
 public:
  explicit StateUncertainty(double joint_sigma_rad) {
    covariance_.joint_rad2.setConstant(joint_sigma_rad * joint_sigma_rad);
  }

  /// A new pose of the odometry; in the order of time.
  void Add(const BasePose& pose);

  /// The covariance at odometry's present pose, for a scene of that stamp. When the pose of the
  /// stamp is no longer held (a scene older than kPoses reports when it came), the oldest counts.
  const StateCovariance& Since(Time scene_stamp, const WheelOdometry& odometry);

 private:
  static constexpr int kPoses = 64;  ///< of the base's reports, 20 ms apart: 1.3 s

  const BasePose& At(Time stamp) const;

  std::array<BasePose, kPoses> poses_{};
  int next_ = 0;
  int count_ = 0;
  bool placed_ = false;
  Time scene_stamp_{};
  BasePose scene_pose_;
  StateCovariance covariance_;
};

}  // namespace pipewright
