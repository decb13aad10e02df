// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace pipewright::hil {

/// Every figure of run.json with its unit and, where the key is known, what it says; a table for
/// each of its objects. Units of keys that are not known are read from their suffix.
std::string RenderFigureTables(const nlohmann::ordered_json& run);

}  // namespace pipewright::hil
