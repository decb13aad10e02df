// SPDX-License-Identifier: MIT
#include "hil/cli/truth_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pipewright::hil {

void WatchTruth(const ControlReport& report, const Emulator& emulator, RunFigures& figures) {
  const Plant& plant = emulator.plant();
  const auto over =
      (plant.joints_rad() - plant.upper_rad()).cwiseMax(plant.lower_rad() - plant.joints_rad());
  figures.joint_limit_excess_rad = figures.cycles == 1
                                       ? over.maxCoeff()
                                       : std::max(figures.joint_limit_excess_rad, over.maxCoeff());
  if (report.state.valid) {
    const BasePose& truth = plant.base();
    figures.pose_error_m =
        std::max(figures.pose_error_m,
                 std::hypot(report.state.q(0) - truth.x_m, report.state.q(1) - truth.y_m));
    figures.pose_error_rad =
        std::max(figures.pose_error_rad,
                 std::abs(std::remainder(report.state.q(2) - truth.yaw_rad, 2 * std::numbers::pi)));
  }
  if (figures.covered_95_s < 0 && emulator.truth().coverage().ratio >= 0.95) {
    figures.covered_95_s = ToSeconds(report.now);
  }
}

}  // namespace pipewright::hil
