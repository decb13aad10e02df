// SPDX-License-Identifier: MIT
#include "hil/cli/scenario_choice.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "hil/plant/robot_description.h"
#include "hil/world/start_check.h"
#include "platform/robot/robot.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {

std::optional<Scenario> LoadToRun(const std::string& scenario,
                                  const std::optional<std::string>& faults) {
  ScenarioResult loaded = LoadScenario(scenario);
  if (loaded.scenario && faults) {
    loaded.errors = LayOver(*faults, *loaded.scenario);
  }
  if (loaded.errors.empty()) {
    const ArmVector home_rad = HomeJoints(TracerUf7());
    StartCheck start = CheckStart(*loaded.scenario, RobotBodiesOf(TracerUf7Description()),
                                  {home_rad.data(), kArmJoints});
    for (const std::string& warning : start.warnings) {
      fmt::print(stderr, "pipewright: warning: {}\n", warning);
    }
    loaded.errors = std::move(start.errors);
  }
  for (const std::string& error : loaded.errors) {
    fmt::print(stderr, "pipewright: {}\n", error);
  }
  return loaded.errors.empty() ? std::move(loaded.scenario) : std::nullopt;
}

}  // namespace pipewright::hil
