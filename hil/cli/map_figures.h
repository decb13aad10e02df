// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "hil/cli/map_run.h"

namespace pipewright::hil {

nlohmann::ordered_json MapJson(const MapInput& input, const MapRun& run, const MapOptions& options);

/// The same for people.
std::string MapTable(const nlohmann::ordered_json& figures);

}  // namespace pipewright::hil
