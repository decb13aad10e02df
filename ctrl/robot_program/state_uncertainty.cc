// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/state_uncertainty.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace pipewright {

void StateUncertainty::Add(const BaseBelief& belief) {
  beliefs_[next_] = belief;
  next_ = (next_ + 1) % kBeliefs;
  count_ = std::min(count_ + 1, kBeliefs);
  measured_ = false;
}

/// The newest that is not newer than stamp, else the oldest.
const BaseBelief& StateUncertainty::At(Time stamp) const {
  int i = next_;
  for (int age = 0; age < count_; ++age) {
    i = (i + kBeliefs - 1) % kBeliefs;
    if (beliefs_[i].by_wheels.stamp <= stamp) {
      break;
    }
  }
  return beliefs_[i];
}

template <typename Estimates, int kMost>
void StateUncertainty::Place(const Estimates& primitives, Anchors<kMost>& anchors) const {
  const Anchors<kMost> before = anchors;
  anchors.clear();
  for (const auto& primitive : primitives) {
    const auto* known = std::find_if(before.begin(), before.end(), [&](const Anchor& anchor) {
      return anchor.id == primitive.id && anchor.last_seen == primitive.last_seen;
    });
    const BaseBelief& belief = known != before.end() ? known->belief : At(primitive.last_seen);
    static_cast<void>(anchors.push_back({primitive.id, primitive.last_seen, belief}));
  }
}

Matrix3d StateUncertainty::Against(const BaseBelief& then, const WheelOdometry& odometry) const {
  const BaseBelief& now = beliefs_[(next_ + kBeliefs - 1) % kBeliefs];
  Matrix3d held = now.covariance + then.covariance;
  const Matrix3d grown = odometry.CovarianceSince(then.by_wheels);
  if (held.trace() < grown.trace()) {
    return held;
  }
  const double turn = now.phi_rad - now.by_wheels.phi_rad;
  Matrix3d R = Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(turn).toRotationMatrix();
  return R * grown * R.transpose();
}

void StateUncertainty::Measure(const WheelOdometry& odometry) {
  covariance_.base = Against(scene_belief_, odometry);
  const auto measure = [&](const auto& anchors, auto& covariances) {
    covariances.clear();
    for (const Anchor& anchor : anchors) {
      static_cast<void>(covariances.push_back(
          anchor.last_seen == scene_stamp_ ? covariance_.base : Against(anchor.belief, odometry)));
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
    scene_belief_ = At(scene.stamp);
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
