// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hil/report/plot.h"
#include "hil/report/world_picture.h"

namespace pipewright::hil {

/// All that the page shows. Anything may be missing: a run that failed early has a page, too.
struct ReportInput {
  nlohmann::ordered_json run;   ///< run.json's object
  nlohmann::ordered_json plan;  ///< plan.jsonl's objects in an array
  std::vector<Plot> plots;      ///< for instance RunRecorder::Plots()
  WorldView world;              ///< for instance ViewOf(scenario, truth); goals come from plan
};

/// The page a person looks at: one self-contained file of well-formed XHTML (as HTML5, too) with
/// verdict, picture, plots, tables; no script, nothing from a network; light, dark, and on paper.
/// A function of its input alone. Each line whose content depends on the wall clock has
/// class="wall" in it.
std::string RenderReport(const ReportInput& input);

}  // namespace pipewright::hil
