// SPDX-License-Identifier: MIT
#include "hil/cli/truth_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pipewright::hil {
namespace {

double Turn(double from_rad, double to_rad) {
  return std::remainder(to_rad - from_rad, 2 * std::numbers::pi);
}

PoseError ErrorOf(const Vector3d& pose, const BasePose& truth) {
  return {std::hypot(pose.x() - truth.x_m, pose.y() - truth.y_m),
          std::abs(Turn(truth.yaw_rad, pose.z()))};
}

PoseError Largest(const PoseError& a, const PoseError& b) {
  return {std::max(a.m, b.m), std::max(a.rad, b.rad)};
}

}  // namespace

/// Between the two moments about the stamp, else the nearest.
BasePose TruthWatch::At(Time stamp) const {
  int later = newest_;
  for (int age = 0; age < kMoments; ++age) {
    const int i = (newest_ + kMoments - age) % kMoments;
    const Moment& earlier = moments_[i];
    if (earlier.stamp <= stamp) {
      const Moment& next = moments_[later];
      const double way_s = ToSeconds(next.stamp - earlier.stamp);
      const double share = way_s > 0 ? ToSeconds(stamp - earlier.stamp) / way_s : 0;
      return {std::lerp(earlier.base.x_m, next.base.x_m, share),
              std::lerp(earlier.base.y_m, next.base.y_m, share),
              earlier.base.yaw_rad + share * Turn(earlier.base.yaw_rad, next.base.yaw_rad)};
    }
    later = i;
  }
  return moments_[later].base;
}

void TruthWatch::Add(const ControlReport& report, const Emulator& emulator, RunFigures& figures) {
  const Plant& plant = emulator.plant();
  newest_ = (newest_ + 1) % kMoments;
  moments_[newest_] = {report.now, plant.base()};
  const auto over =
      (plant.joints_rad() - plant.upper_rad()).cwiseMax(plant.lower_rad() - plant.joints_rad());
  figures.joint_limit_excess_rad = figures.cycles == 1
                                       ? over.maxCoeff()
                                       : std::max(figures.joint_limit_excess_rad, over.maxCoeff());
  if (report.state.valid) {
    const BasePose truth = At(report.state.stamp);
    figures.pose_final = ErrorOf(report.state.q.head<3>(), truth);
    figures.pose_max = Largest(figures.pose_max, figures.pose_final);
    figures.wheels_max = Largest(figures.wheels_max, ErrorOf(report.pose.by_wheels, truth));
  }
  if (figures.covered_95_s < 0 && emulator.truth().coverage().ratio >= 0.95) {
    figures.covered_95_s = ToSeconds(report.now);
  }
}

}  // namespace pipewright::hil
