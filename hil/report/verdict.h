// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace pipewright::hil {

/// One thing that a run must have shown.
struct Check {
  enum class Result : unsigned char { kMet, kMissed, kNotMeasured };
  std::string name{};
  std::string key{};  ///< of run.json
  std::string measured{};
  std::string target{};
  Result result = Result::kNotMeasured;
};

/// The checks of an inspection: complete, nothing touched, coverage, limits kept, no allocation, no
/// frame lost. A figure that run.json lacks is not measured.
std::vector<Check> Checks(const nlohmann::ordered_json& run);

/// The head of the page: what came out in words, the figures that matter most, the checks.
std::string RenderVerdict(const nlohmann::ordered_json& run);

}  // namespace pipewright::hil
