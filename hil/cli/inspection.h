// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "ctrl/robot_program/robot_program.h"
#include "hil/world/scenario.h"

namespace pipewright::hil {

/// What a person asks of `pipewright inspect`.
struct InspectionOptions {
  std::string scenario = "pipes3";    ///< a shipped name or a file
  std::optional<std::string> faults;  ///< likewise, laid over the scenario
  std::uint64_t seed = 1;
  PlannerKind planner = PlannerKind::kCfnbv;
  SvfiMode svfi = SvfiMode::kExact;
  double alpha = 0.7;
  bool scans_correct = true;  ///< the base's pose, which else is the wheels' alone
  bool joint_risk = false;    ///< alpha is of all constraints of a cycle together
  double rate_hz = 100;
  bool realtime = false;
  std::string bus = "loopback";  ///< see BusChoice
  bool no_devices = false;       ///< on a real bus: the devices are elsewhere
  std::string camera;            ///< with no_devices: path of the depth stream; empty: none
  bool ask_fifo = true;          ///< on a real bus: real-time scheduling and locked memory
  std::string out;               ///< empty: runs/<scenario>[-<faults>]-<planner>-<seed>
  bool record_depth = false;     ///< into the folder, for a replay
  bool json = false;
  double time_limit_s = 1800;  ///< of simulated time
};

/// The robot's program for one run: a function of the scenario and the options, nothing else.
RobotProgramConfig ProgramConfig(const Scenario& scenario, const InspectionOptions& options);

const char* Name(PlannerKind planner);

}  // namespace pipewright::hil
