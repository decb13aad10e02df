// SPDX-License-Identifier: MIT
#include "hil/cli/inspection.h"

#include "hil/cli/bus_choice.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

VoxelIndex Index(const std::array<int, 3>& v) { return {v[0], v[1], v[2]}; }

MapConfig Map(const Scenario& scenario) {
  MapConfig map;
  const VoxelRange stored = VoxelsOf(scenario.map);
  const VoxelRange workspace = VoxelsOf(scenario.workspace);
  map.lo = Index(stored.lo);
  map.hi = Index(stored.hi);
  map.workspace_lo = Index(workspace.lo);
  map.workspace_hi = Index(workspace.hi);
  map.width_m = kVoxelWidth_m;
  map.brick_capacity = BricksOfBox(map);
  return map;
}

ArmVector StartJoints(const StartPose& start) {
  if (start.joints_rad.empty()) {
    return HomeJoints(TracerUf7());
  }
  return Eigen::Map<const ArmVector>(start.joints_rad.data());
}

}  // namespace

RobotProgramConfig ProgramConfig(const Scenario& scenario, const InspectionOptions& options) {
  RobotProgramConfig config;
  config.start_joints_rad = StartJoints(scenario.start);

  ControlTaskConfig& control = config.control;
  control.start.x_m = scenario.start.x_m;
  control.start.y_m = scenario.start.y_m;
  control.start.phi_rad = scenario.start.yaw_rad;
  control.localization.odometry.track_m = TracerUf7().base.track_m;
  control.law.constraints.period_s = 1 / options.rate_hz;
  std::string error;
  control.arm.cycle_ms = ArmCycle_ms(options.rate_hz, ParseBus(options.bus, &error).shared);
  control.law.constraints.svfi = options.svfi;
  control.law.constraints.alpha = options.alpha;
  control.law.constraints.joint_risk = options.joint_risk;
  control.scans_correct = options.scans_correct;
  if (options.planner == PlannerKind::kCfnbv) {
    control.law.reached = 0.02;  // a view's worth does not hang on the last centimetre
  }

  config.mapping.map = Map(scenario);
  config.mapping.start_clearance_m = scenario.start.clearance_m;
  config.mapping.seed = options.seed;
  config.mapping.localize = options.scans_correct;

  config.mission = DefaultMission();
  config.mission.planner = options.planner;
  config.mission.seed = options.seed;
  config.mission.mission_timeout = FromSeconds(options.time_limit_s);
  return config;
}

const char* Name(PlannerKind planner) {
  switch (planner) {
    case PlannerKind::kCfnbv:
      return "cfnbv";
    case PlannerKind::kCfnbvPaper:
      return "cfnbv_paper";
  }
  return "?";
}

}  // namespace pipewright::hil
