// SPDX-License-Identifier: MIT
#include "hil/report/report.h"

#include <fmt/format.h>

#include "embedded/ReportPage.h"
#include "hil/report/figure_tables.h"
#include "hil/report/markup.h"
#include "hil/report/plan_table.h"
#include "hil/report/verdict.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

std::string TextOf(const Json& run, const char* key) {
  if (!run.is_object() || !run.contains(key)) {
    return "?";
  }
  const Json& value = run.at(key);
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// The end of the mission, or of what was recorded of it. [s]
double EndOf(const ReportInput& input) {
  double end_s = 0;
  if (input.run.is_object() && input.run.contains("sim_time_s") &&
      input.run.at("sim_time_s").is_number()) {
    end_s = input.run.at("sim_time_s").get<double>();
  }
  for (const Plot& plot : input.plots) {
    for (const Series& series : plot.series) {
      end_s = series.t_s.empty() ? end_s : std::max(end_s, series.t_s.back());
    }
  }
  return end_s;
}

std::string Plots(const ReportInput& input) {
  const double end_s = EndOf(input);
  std::string html;
  for (const Plot& plot : input.plots) {
    html += RenderPlot(plot, end_s);
  }
  return html.empty() ? "<p>Nothing was recorded.</p>\n" : html;
}

std::string Picture(const ReportInput& input) {
  WorldView world = input.world;
  if (world.goals.empty()) {
    world.goals = GoalsOf(input.plan);
  }
  const std::string views = RenderWorld(world);
  return views.empty() ? "<p>The world was not drawn.</p>\n" : views;
}

}  // namespace

std::string RenderReport(const ReportInput& input) {
  const Json& run = input.run;
  return Fill(embedded::ReportPage(), {{"scenario", Escape(TextOf(run, "scenario"))},
                                       {"planner", Escape(TextOf(run, "planner"))},
                                       {"seed", Escape(TextOf(run, "seed"))},
                                       {"verdict", RenderVerdict(run)},
                                       {"picture", Picture(input)},
                                       {"plots", Plots(input)},
                                       {"plan", RenderPlanTable(input.plan)},
                                       {"figures", RenderFigureTables(run)}});
}

}  // namespace pipewright::hil
