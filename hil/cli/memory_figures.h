// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ctrl/robot_program/robot_program.h"

namespace pipewright::hil {

/// One part of the robot's program: all of its memory is taken at start.
struct MemoryPart {
  std::string name;
  std::string capacity;  ///< what it is room for
  std::int64_t in_place = 0;
  std::int64_t heap = 0;
};

/// The parts of a RobotProgram of this configuration. Their sum is all of it, but for a few bytes
/// of flags. Of the heap, what the parts say of themselves; of tasks, what the allocator gave to
/// one that was made for the purpose, blocks' heads included (0 under a sanitizer).
std::vector<MemoryPart> MemoryParts(const RobotProgramConfig& config);

nlohmann::ordered_json MemoryJson(const std::string& scenario, const RobotProgramConfig& config,
                                  const std::vector<MemoryPart>& parts);
std::string MemoryTable(const nlohmann::ordered_json& figures);

}  // namespace pipewright::hil
