// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "ctrl/constraints/svfi.h"
#include "perception/localization/wheel_odometry.h"

namespace pipewright {

/// The base's pose as the wheels alone tell it, and what is known of the pose that the robot moves
/// by, which scans correct.
struct BaseBelief {
  BasePose by_wheels;
  double phi_rad = 0;                      ///< of the corrected pose
  Matrix3d covariance = Matrix3d::Zero();  ///< of it, in W
};

/// How wrong q may be against the scene and the map that the control task holds.
///
/// Not against the world: the mapping task places what the camera sees by the same pose, so that
/// what was wrong with it at that time moved the robot and its surroundings as one body, and no
/// distance. What matters is the error since then, and `then` is each primitive's own: one that has
/// been out of view stays where it was placed. Two bounds hold for it, and the smaller counts:
///
/// - what the wheels' covariance grew by since then (WheelOdometry::CovarianceSince), turned from
///   the heading that they tell to that of W: the better one for what was just seen. It goes on
///   growing when nothing new comes.
/// - the covariance of the corrected pose then and that of now, as of two errors: it does not grow
///   while scans correct the pose.
///
/// `base` is since the scene's stamp, for the map; to_plane and to_pipe since the primitive's
/// last_seen. Joints: the noise of their readings now, each alone. That of the time of the frame is
/// part of the camera's pose, thus of the primitive's own covariance (PrimitiveConfig::pose_sigma).
///
/// The belief at last_seen is looked up when the primitive is seen, and kept while it is not:
/// nothing is needed of the way between.
class StateUncertainty {
 public:
  explicit StateUncertainty(double joint_sigma_rad) {
    covariance_.joint_rad2.setConstant(joint_sigma_rad * joint_sigma_rad);
  }

  /// What is believed at a report of the base; in the order of time.
  void Add(const BaseBelief& belief);

  /// The covariance at the newest belief, whose wheels are the odometry's, for that scene. When the
  /// belief of a stamp is no longer held (one older than kBeliefs reports when it first came), the
  /// oldest counts.
  const StateCovariance& Since(const Scene& scene, const WheelOdometry& odometry);

 private:
  static constexpr int kBeliefs = 64;  ///< of the base's reports, 20 ms apart: 1.3 s

  /// What was believed when a primitive was last seen.
  struct Anchor {
    std::uint32_t id = 0;
    Time last_seen{};
    BaseBelief belief;
  };
  template <int kMost>
  using Anchors = FixedVector<Anchor, kMost>;

  const BaseBelief& At(Time stamp) const;
  template <typename Estimates, int kMost>
  void Place(const Estimates& primitives, Anchors<kMost>& anchors) const;
  Matrix3d Against(const BaseBelief& then, const WheelOdometry& odometry) const;
  void Measure(const WheelOdometry& odometry);

  std::array<BaseBelief, kBeliefs> beliefs_{};
  int next_ = 0;
  int count_ = 0;
  bool placed_ = false;
  bool measured_ = false;  ///< covariance_ is of the newest belief and scene
  Time scene_stamp_{};
  BaseBelief scene_belief_;
  Anchors<Scene::kMaxPlanes> planes_;
  Anchors<Scene::kMaxPipes> pipes_;
  StateCovariance covariance_;
};

}  // namespace pipewright
