// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hil/world/robot_bodies.h"
#include "hil/world/scenario.h"

namespace pipewright::hil {

/// What a scenario's start cannot be, "file:line:column: start.key: what", and what the person who
/// wrote it should know.
struct StartCheck {
  std::vector<std::string> errors;  ///< joints beyond their limits; a robot that touches something
  std::vector<std::string> warnings;  ///< something is nearer than start.clearance_m says
};

/// @param home_rad  joints of a start that names none; the robot's number of them
StartCheck CheckStart(const Scenario& scenario, const RobotBodies& robot,
                      std::span<const double> home_rad);

}  // namespace pipewright::hil
