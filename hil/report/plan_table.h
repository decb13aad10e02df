// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "platform/core/frames.h"

namespace pipewright::hil {

/// The decisions of plan.jsonl, one row each; of more than 400 the first and the last 200. A value
/// that a step lacks is left empty.
std::string RenderPlanTable(const nlohmann::ordered_json& plan);

/// Where the goals were, in W, in their order.
std::vector<Vector3d> GoalsOf(const nlohmann::ordered_json& plan);

}  // namespace pipewright::hil
