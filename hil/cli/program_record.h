// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "hil/cli/inspection.h"
#include "hil/world/scenario.h"

namespace pipewright::hil {

/// run.json's "program": what ProgramConfig() takes of scenario and options, "seed" and "planner"
/// aside, which run.json has at its top. With them, a robot program can be set up again as it was,
/// without the scenario's file.
nlohmann::ordered_json ProgramJson(const Scenario& scenario, const InspectionOptions& options);

struct RecordedProgram {
  Scenario scenario;  ///< its workspace, map and start only
  InspectionOptions options;
  std::optional<Time> interrupted;  ///< when somebody stopped the run

  RobotProgramConfig config() const { return ProgramConfig(scenario, options); }
};

struct RecordedProgramResult {
  std::optional<RecordedProgram> program;
  std::string error;  ///< names the key that is wrong or missing
};

/// Reads a run.json back. @param run  any JSON
RecordedProgramResult ReadProgram(const nlohmann::ordered_json& run);

}  // namespace pipewright::hil
