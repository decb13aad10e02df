// SPDX-License-Identifier: MIT
#include "hil/cli/truth_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pipewright::hil {
namespace {

PoseError ErrorOf(const Vector3d& pose, const BasePose& truth) {
  return {std::hypot(pose.x() - truth.x_m, pose.y() - truth.y_m),
          std::abs(std::remainder(pose.z() - truth.yaw_rad, 2 * std::numbers::pi))};
}

PoseError Largest(const PoseError& a, const PoseError& b) {
  return {std::max(a.m, b.m), std::max(a.rad, b.rad)};
}

}  // namespace

void WatchTruth(const ControlReport& report, const Emulator& emulator, RunFigures& figures) {
  const Plant& plant = emulator.plant();
  const auto over =
      (plant.joints_rad() - plant.upper_rad()).cwiseMax(plant.lower_rad() - plant.joints_rad());
  figures.joint_limit_excess_rad = figures.cycles == 1
                                       ? over.maxCoeff()
                                       : std::max(figures.joint_limit_excess_rad, over.maxCoeff());
  if (report.state.valid) {
    figures.pose_final = ErrorOf(report.state.q.head<3>(), plant.base());
    figures.pose_max = Largest(figures.pose_max, figures.pose_final);
  }
  if (figures.covered_95_s < 0 && emulator.truth().coverage().ratio >= 0.95) {
    figures.covered_95_s = ToSeconds(report.now);
  }
}

}  // namespace pipewright::hil
