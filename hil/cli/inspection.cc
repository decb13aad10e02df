// SPDX-License-Identifier: MIT
#include "hil/cli/inspection.h"

#include "ctrl/robot_program/site_config.h"
#include "hil/cli/bus_choice.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
RobotProgramConfig ProgramConfig(const Scenario& scenario, const InspectionOptions& options) {
  RobotProgramConfig config;
  SetSite(scenario, TracerUf7(), &config);

  ControlTaskConfig& control = config.control;
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
