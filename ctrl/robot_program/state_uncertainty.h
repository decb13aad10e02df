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
/// and no distance. What matters is the error since then, and `then` is each primitive's own: one
/// that has been out of view stays where it was placed, and the odometry's error has grown since.
///
/// - base: what the odometry's covariance grew by since the scene's stamp, for the map
///   (WheelOdometry::CovarianceSince). It goes on growing when no new scene comes.
/// - to_plane, to_pipe: likewise since the primitive's last_seen.
/// - joints: the noise of their readings now, each alone. That of the time of the frame is part of
///   the camera's pose, thus of the primitive's own covariance (PrimitiveConfig::pose_sigma).
///
/// The base's pose at last_seen is looked up when the primitive is seen, and kept while it is not:
/// nothing is needed of the way between.
class StateUncertainty {
 public:
  explicit StateUncertainty(double joint_sigma_rad) {
    covariance_.joint_rad2.setConstant(joint_sigma_rad * joint_sigma_rad);
  }

  /// A new pose of the odometry; in the order of time.
  void Add(const BasePose& pose);

  /// The covariance at odometry's present pose, for that scene. When the pose of a stamp is no
  /// longer held (one older than kPoses reports when it first came), the oldest counts.
  const StateCovariance& Since(const Scene& scene, const WheelOdometry& odometry);

 private:
  static constexpr int kPoses = 64;  ///< of the base's reports, 20 ms apart: 1.3 s

  /// Where the base was, as it held, when a primitive was last seen.
  struct Anchor {
    std::uint32_t id = 0;
    Time last_seen{};
    BasePose pose;
  };
  template <int kMost>
  using Anchors = FixedVector<Anchor, kMost>;

  const BasePose& At(Time stamp) const;
  template <typename Estimates, int kMost>
  void Place(const Estimates& primitives, Anchors<kMost>& anchors) const;
  void Measure(const WheelOdometry& odometry);

  std::array<BasePose, kPoses> poses_{};
  int next_ = 0;
  int count_ = 0;
  bool placed_ = false;
  bool measured_ = false;  ///< covariance_ is of the newest pose and scene
  Time scene_stamp_{};
  BasePose scene_pose_;
  Anchors<Scene::kMaxPlanes> planes_;
  Anchors<Scene::kMaxPipes> pipes_;
  StateCovariance covariance_;
};

}  // namespace pipewright
