// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/state_uncertainty.h"

#include <algorithm>

namespace pipewright {

void StateUncertainty::Add(const BasePose& pose) {
  poses_[next_] = pose;
  next_ = (next_ + 1) % kPoses;
  count_ = std::min(count_ + 1, kPoses);
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

const StateCovariance& StateUncertainty::Since(Time scene_stamp, const WheelOdometry& odometry) {
  if (count_ > 0) {
    if (!placed_ || scene_stamp != scene_stamp_) {
      placed_ = true;
      scene_stamp_ = scene_stamp;
      scene_pose_ = At(scene_stamp);
    }
    covariance_.base = odometry.CovarianceSince(scene_pose_);
  }
  return covariance_;
}

}  // namespace pipewright
