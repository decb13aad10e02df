// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hil/world/conditions.h"
#include "hil/world/shipped_toml.h"
#include "hil/world/solid.h"
#include "platform/core/frames.h"
#include "platform/toml/site.h"

namespace pipewright::hil {

/// A world, a robot's start in it, and how its devices do there. The format is documented in
/// hil/world/scenarios/pipes3.toml.
///
///   name, description      text; name is required
///   [workspace] [map] [start]   the fields of Site
///   [[plane]]              name normal offset_m, ground (false); free where normal'p > offset
///   [[box]]                name center_m size_m, rpy_rad (0 0 0)
///   [[cylinder]]           name from_m to_m radius_m
///   [[mesh]]               name file, scale (1), position_m (0 0 0), rpy_rad (0 0 0)
///   [camera]               the fields of CameraSpec
///   [base]                 the fields of BaseSpec
///   [[fault]]              device kind at_s (0), for slip also for_s left (0) right (0)
struct Scenario : Site, Conditions {
  std::string name;
  std::string description;
  std::vector<Solid> solids;  ///< planes, boxes, cylinders, meshes; each in the order of the file
};

/// A scenario, or everything that is wrong with it, one line each: "file:line:column: key: what".
struct ScenarioResult {
  std::optional<Scenario> scenario;
  std::vector<std::string> errors;
};

/// @param origin     the name in error messages
/// @param directory  where relative mesh files are looked for
ScenarioResult ParseScenario(std::string_view toml, const std::string& origin,
                             const std::string& directory);

/// A shipped scenario by its name, else a file.
ScenarioResult LoadScenario(const std::string& name_or_file);

const std::vector<ShippedToml>& ShippedScenarios();

}  // namespace pipewright::hil
