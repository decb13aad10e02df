// SPDX-License-Identifier: MIT
#include "tests/bench/robot_side.h"

#include "platform/robot/uf7.h"

namespace pipewright::bench {

ControlTaskConfig TaskConfig(const LoopConfig& config) {
  ControlTaskConfig task;
  task.start.x_m = config.x_m;
  task.start.y_m = config.y_m;
  task.start.phi_rad = config.phi_rad;
  task.localization.odometry.track_m = TracerUf7().base.track_m;
  task.law.constraints.period_s = config.period_s;
  task.law.reached = config.reached;
  task.arm.cycle_ms = config.arm_cycle_ms;
  return task;
}

}  // namespace pipewright::bench
