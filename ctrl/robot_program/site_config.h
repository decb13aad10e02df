// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/robot_program/robot_program.h"
#include "platform/toml/site.h"

namespace pipewright {

/// Puts the robot where the site has it start, and gives the map the site's bounds.
void SetSite(const Site& site, const RobotModel<kArmJoints>& robot, RobotProgramConfig* config);

}  // namespace pipewright
