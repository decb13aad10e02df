// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "ctrl/robot_program/robot_program.h"
#include "hil/cli/inspection.h"
#include "hil/emulator/emulator.h"
#include "platform/can/loopback_bus.h"

namespace pipewright::hil {

/// How far a pose is from the truth.
struct PoseError {
  double m = 0;
  double rad = 0;
};

/// What a run adds up, cycle by cycle.
struct RunFigures {
  std::uint64_t cycles = 0;
  std::uint64_t heap_allocations = 0;  ///< inside control cycles
  int qp_iterations_max = 0;
  std::uint64_t qp_cap_hits = 0;
  std::uint64_t svfi_checked = 0;
  std::uint64_t svfi_held = 0;
  std::uint64_t svfi_fallbacks = 0;
  std::uint64_t svfi_out_of_reach = 0;
  int rows_max = 0;
  std::vector<float> qp_us;           ///< wall clock, one a cycle
  std::vector<float> cycle_us;        ///< likewise
  std::vector<float> step_ms;         ///< one a planning step
  double joint_limit_excess_rad = 0;  ///< of the plant, largest; <= 0: never passed
  int joint_hard_stops = 0;
  PoseError pose_max;        ///< of the pose that the robot moves by, each largest
  PoseError pose_final;      ///< at the last cycle with a valid state
  PoseError wheels_max;      ///< of what the wheels alone tell
  double covered_95_s = -1;  ///< when the true coverage ratio first reached 0.95; < 0: never
  double wall_s = 0;
  std::optional<Time> interrupted;  ///< when somebody asked the robot to stop

  void Add(const ControlReport& report);
};

/// p in [0, 1]; the smallest value that at least that share does not exceed. 0 for none.
double Percentile(std::vector<float> values, double p);

struct CanFigures {
  std::uint64_t tx = 0;
  std::uint64_t rx = 0;
  std::uint64_t dropped = 0;
  double load_peak = 0;
};

/// run.json's "faults": the name of what was laid over the scenario; null when nothing was.
nlohmann::ordered_json FaultsJson(const InspectionOptions& options);

/// run.json's object.
/// @param emulator  null: the devices are elsewhere, and what only the truth can tell is null, too
nlohmann::ordered_json RunJson(const InspectionOptions& options, const Scenario& scenario,
                               const RobotProgram& program, const Emulator* emulator,
                               const RunFigures& figures, const CanFigures& can, Time end,
                               const std::string& stop_detail);

/// plan.jsonl's object of one planning step.
nlohmann::ordered_json PlanJson(Time now, const MissionOutput& output, const Goal& goal,
                                const MapCounts& counts);

/// The same figures as a short table for people.
std::string RunTable(const nlohmann::ordered_json& run, const std::string& folder);

/// Whether the run met what it is for: complete, nothing touched, no allocation. Contacts that are
/// not known here are left to who knows them.
bool Passed(const nlohmann::ordered_json& run);

}  // namespace pipewright::hil
