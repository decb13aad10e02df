// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "perception/localization/pose_filter.h"

namespace pipewright::test {

inline constexpr double kTrack_m = 0.35;
inline constexpr int kReport_ms = 20;

/// A base that moves apart from the code under test, and wheels that tell of it what they tell.
struct Drive {
  Vector3d truth = Vector3d::Zero();
  double left_m = 0;
  double right_m = 0;
  Time now{};

  /// One report's time; the base turns yaw_scale times as far as its wheels tell.
  Status Run(PoseFilter& filter, double v_mps, double w_radps, double yaw_scale = 1) {
    if (now == Time{}) {
      (void)filter.Step(now, 0, 0, 0, 0);  // where the wheels' counts begin
    }
    for (int i = 0; i < kReport_ms; ++i) {
      const double dt = 1e-3;
      const double w_true = w_radps * yaw_scale;
      truth.x() += v_mps * dt * std::cos(truth.z() + w_true * dt / 2);
      truth.y() += v_mps * dt * std::sin(truth.z() + w_true * dt / 2);
      truth.z() += w_true * dt;
      left_m += (v_mps - w_radps * kTrack_m / 2) * dt;
      right_m += (v_mps + w_radps * kTrack_m / 2) * dt;
    }
    now += std::chrono::milliseconds(kReport_ms);
    return filter.Step(now, v_mps, w_radps, left_m, right_m);
  }
};

inline Mat<3, 3> Information(double sigma_m, double sigma_rad) {
  return Vector3d(1 / (sigma_m * sigma_m), 1 / (sigma_m * sigma_m), 1 / (sigma_rad * sigma_rad))
      .asDiagonal();
}

inline Vector3d PoseOf(const PoseFilter& filter) {
  const BasePose pose = filter.pose();
  return {pose.x_m, pose.y_m, pose.phi_rad};
}

/// Without the quantum, so that only what a test puts in is wrong.
inline PoseFilterConfig Fine() { return {.odometry = {.track_m = kTrack_m, .quantum_m = 1e-9}}; }

}  // namespace pipewright::test
