// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "hil/world/scenario.h"

namespace pipewright::hil {

/// The scenario, a shipped name or a file, with the faults laid over it, if the robot can start in
/// it; else says on standard error why not. Warnings go there, too.
std::optional<Scenario> LoadToRun(const std::string& scenario,
                                  const std::optional<std::string>& faults);

}  // namespace pipewright::hil
