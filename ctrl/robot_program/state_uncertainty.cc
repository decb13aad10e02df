// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/state_uncertainty.h"

#include <algorithm>

namespace pipewright {

void StateUncertainty::Add(const BasePose& pose) {
  poses_[next_] = pose;
  next_ = (next_ + 1) % kPoses;
  count_ = std::min(count_ + 1, kPoses);
  measured_ = false;
}

/// The newest pose that is not newer than stamp, else the oldest.
const BasePose& StateUncertainty::At(Time stamp) const {
  int i = next_;
  for (int age = 0; age < count_; ++age) {
    i = (i + kPoses - 1) % kPoses;
    if (poses_[i].stamp <= stamp) {
      break;
    }
  }
  return poses_[i];
}

template <typename Estimates, int kMost>
void StateUncertainty::Place(const Estimates& primitives, Anchors<kMost>& anchors) const {
  const Anchors<kMost> before = anchors;
  anchors.clear();
  for (const auto& primitive : primitives) {
    const auto* known = std::find_if(before.begin(), before.end(), [&](const Anchor& anchor) {
      return anchor.id == primitive.id && anchor.last_seen == primitive.last_seen;
    });
    const BasePose& pose = known != before.end() ? known->pose : At(primitive.last_seen);
    static_cast<void>(anchors.push_back({primitive.id, primitive.last_seen, pose}));
  }
}

void StateUncertainty::Measure(const WheelOdometry& odometry) {
  covariance_.base = odometry.CovarianceSince(scene_pose_);
  const auto measure = [&](const auto& anchors, auto& covariances) {
    covariances.clear();
    for (const Anchor& anchor : anchors) {
      static_cast<void>(covariances.push_back(anchor.last_seen == scene_stamp_
                                                  ? covariance_.base
                                                  : odometry.CovarianceSince(anchor.pose)));
    }
  };
  measure(planes_, covariance_.to_plane);
  measure(pipes_, covariance_.to_pipe);
}

const StateCovariance& StateUncertainty::Since(const Scene& scene, const WheelOdometry& odometry) {
  if (count_ == 0) {
    return covariance_;
  }
  if (!placed_ || scene.stamp != scene_stamp_) {
    placed_ = true;
    measured_ = false;
    scene_stamp_ = scene.stamp;
    scene_pose_ = At(scene.stamp);
    Place(scene.planes, planes_);
    Place(scene.pipes, pipes_);
  }
  if (!measured_) {
    measured_ = true;
    Measure(odometry);
  }
  return covariance_;
}

}  // namespace pipewright
