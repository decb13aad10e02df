// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ctrl/robot_program/robot_program.h"
#include "hil/cli/inspection.h"
#include "hil/emulator/emulator.h"
#include "hil/report/run_recorder.h"

namespace pipewright::hil {

/// What the page's plots hold values against.
RunLimits LimitsOf(const RobotProgramConfig& config);

/// @param truth  null: not known here
CycleSample CycleSampleOf(const ControlReport& report, const Clearance* truth, double cycle_us);

/// @param base_load, arm_load  of the buses, 0 to 1
MapSample MapSampleOf(const VoxelGrid& map, const Emulator& emulator, double base_load,
                      double arm_load);

/// report.html's text.
/// @param truth  null: not known here
std::string ReportPage(const nlohmann::ordered_json& run, const nlohmann::ordered_json& plan,
                       const RunRecorder& recorder, const Scenario& scenario, const Truth* truth);

}  // namespace pipewright::hil
