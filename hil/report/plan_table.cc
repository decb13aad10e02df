// SPDX-License-Identifier: MIT
#include "hil/report/plan_table.h"

#include <fmt/format.h>

#include "hil/report/markup.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;
using Pointer = Json::json_pointer;

constexpr std::size_t kEnds = 200;

struct Column {
  const char* head;
  const char* title;
  const char* pointer;
  bool number = true;
};

constexpr Column kColumns[] = {
    {"step", "", "/step"},
    {"t [s]", "simulated time", "/t_s"},
    {"decision", "", "/decision", false},
    {"goal", "its number", "/goal/id"},
    {"position [m]", "of the camera: x, y, z in the world", "/goal/p_WS"},
    {"points", "waypoints of the way there", "/goal/waypoints"},
    {"candidates", "views that were valued", "/candidates"},
    {"reachable", "of these, with a free robot posture", "/reachable"},
    {"ways", "whole-body paths that were tried", "/paths_tried"},
    {"visual gain", "expected, nats", "/gain/visual"},
    {"coverage gain", "expected, nats", "/gain/coverage"},
    {"weighted gain", "as the planner weighs them", "/gain/weighted"},
    {"way [s]", "its duration", "/duration_s"},
    {"unknown left", "voxels that are still to be seen", "/left/unknown"},
    {"uncovered left", "voxels that are still to be covered", "/left/uncovered"},
    {"given up", "voxels", "/left/given_up"},
};

bool HasNumbers(const Json& value) {
  return value.is_array() && value.size() == 3 && value[0].is_number() && value[1].is_number() &&
         value[2].is_number();
}

std::string Cell(const Json& step, const char* pointer) {
  const Pointer where(pointer);
  if (!step.contains(where)) {
    return "<td></td>";
  }
  const Json& value = step.at(where);
  if (HasNumbers(value)) {
    return fmt::format(R"(<td class="num">{:.2f}, {:.2f}, {:.2f}</td>)", value[0].get<double>(),
                       value[1].get<double>(), value[2].get<double>());
  }
  if (value.is_number_float()) {
    return fmt::format(R"(<td class="num">{:.1f}</td>)", value.get<double>());
  }
  if (value.is_number()) {
    return fmt::format(R"(<td class="num">{}</td>)", Number(value.get<double>()));
  }
  return fmt::format("<td>{}</td>",
                     Escape(value.is_string() ? value.get<std::string>() : value.dump()));
}

}  // namespace

std::string RenderPlanTable(const Json& plan) {
  if (!plan.is_array() || plan.empty()) {
    return "<p>No planning step was taken.</p>\n";
  }
  std::string html = "<div class=\"scroll\"><table class=\"plan\"><thead><tr>";
  for (const Column& column : kColumns) {
    html += fmt::format(R"(<th{} title="{}">{}</th>)", column.number ? R"( class="num-head")" : "",
                        Escape(column.title), Escape(column.head));
  }
  html += "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < plan.size(); ++i) {
    if (plan.size() > 2 * kEnds && i == kEnds) {
      const std::size_t skipped = plan.size() - 2 * kEnds;
      html += fmt::format("<tr><td colspan=\"{}\">… {} more steps are in plan.jsonl …</td></tr>\n",
                          std::size(kColumns), skipped);
      i += skipped;
    }
    html += "<tr>";
    for (const Column& column : kColumns) {
      html += Cell(plan[i], column.pointer);
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::vector<Vector3d> GoalsOf(const Json& plan) {
  std::vector<Vector3d> goals;
  if (!plan.is_array()) {
    return goals;
  }
  const Pointer where("/goal/p_WS");
  for (const Json& step : plan) {
    if (step.contains(where) && HasNumbers(step.at(where))) {
      const Json& p = step.at(where);
      goals.emplace_back(p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
    }
  }
  return goals;
}

}  // namespace pipewright::hil
