// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "ctrl/robot_program/control_task.h"
#include "plan/mission/mission.h"

namespace pipewright {

/// What stopped the mission, in words; empty when it is complete.
std::string StopDetail(const MissionOutput& mission, const ControlReport& report, bool camera_lost);

}  // namespace pipewright
