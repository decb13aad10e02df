// SPDX-License-Identifier: MIT
#include "hil/report/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hil/report/markup.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;
using Pointer = Json::json_pointer;

enum class Relation : unsigned char { kEqual, kAtLeast, kBelow, kAbove, kAtMost };

/// A check on one number of run.json.
struct Rule {
  const char* name;
  const char* pointer;
  Relation relation;
  double target;
  double scale;  ///< from run.json's unit to the shown one
  const char* unit;
};

constexpr Rule kRules[] = {
    {"Contacts", "/contacts", Relation::kEqual, 0, 1, ""},
    {"Coverage of what can be covered", "/coverage/ratio", Relation::kAtLeast, 0.95, 100, "%"},
    {"Smallest clearance to walls", "/min_clearance_m/plane", Relation::kAbove, 0, 1000, "mm"},
    {"Smallest clearance to pipes", "/min_clearance_m/pipe", Relation::kAbove, 0, 1000, "mm"},
    {"Smallest clearance to itself", "/min_clearance_m/self", Relation::kAbove, 0, 1000, "mm"},
    {"Past a joint limit", "/control/joint_limit_excess_rad", Relation::kAtMost, 0, 1, "rad"},
    {"Joints at a hard stop", "/control/joint_hard_stops", Relation::kEqual, 0, 1, ""},
    {"Sideways speed of the base", "/control/lateral_speed_max_mps", Relation::kBelow, 1e-9, 1,
     "m/s"},
    {"Heap allocations in control cycles", "/control/heap_allocations", Relation::kEqual, 0, 1, ""},
    {"CAN frames dropped", "/can/dropped", Relation::kEqual, 0, 1, ""},
};

bool Holds(Relation relation, double value, double target) {
  switch (relation) {
    case Relation::kEqual:
      return value == target;
    case Relation::kAtLeast:
      return value >= target;
    case Relation::kBelow:
      return value < target;
    case Relation::kAbove:
      return value > target;
    case Relation::kAtMost:
      return value <= target;
  }
  return false;
}

const char* Sign(Relation relation) {
  switch (relation) {
    case Relation::kEqual:
      return "";
    case Relation::kAtLeast:
      return "≥ ";
    case Relation::kBelow:
      return "< ";
    case Relation::kAbove:
      return "> ";
    case Relation::kAtMost:
      return "≤ ";
  }
  return "";
}

std::string KeyOf(std::string pointer) {
  std::replace(pointer.begin(), pointer.end(), '/', '.');
  return pointer.substr(1);
}

std::string WithUnit(double value, const char* unit) {
  return *unit == 0 ? Number(value) : Number(value) + "\u00A0" + unit;
}

const Json* Find(const Json& run, const char* pointer) {
  const Pointer where(pointer);
  return run.contains(where) ? &run.at(where) : nullptr;
}

Check Apply(const Rule& rule, const Json& run) {
  Check check{.name = rule.name, .key = KeyOf(rule.pointer), .measured = "not measured"};
  check.target = Sign(rule.relation) + WithUnit(rule.target * rule.scale, rule.unit);
  const Json* value = Find(run, rule.pointer);
  if (value == nullptr) {
    return check;
  }
  if (value->is_null() && rule.relation == Relation::kAbove) {
    check.measured = "nothing near";  // a clearance without bound
    check.result = Check::Result::kMet;
  } else if (value->is_number()) {
    const double number = value->get<double>();
    check.measured = WithUnit(rule.scale * number, rule.unit);
    check.result =
        Holds(rule.relation, number, rule.target) ? Check::Result::kMet : Check::Result::kMissed;
  }
  return check;
}

Check MissionCheck(const Json& run) {
  Check check{.name = "Mission", .key = "stop_reason", .measured = "not measured"};
  check.target = "complete";
  if (const Json* stop = Find(run, "/stop_reason"); stop != nullptr && stop->is_string()) {
    check.measured = stop->get<std::string>();
    check.result = *stop == "complete" ? Check::Result::kMet : Check::Result::kMissed;
  }
  return check;
}

std::string Row(const Check& check) {
  constexpr const char* kClass[] = {"met", "missed", "unknown"};
  constexpr const char* kWord[] = {"✓ met", "✗ missed", "? not measured"};
  const auto result = static_cast<std::size_t>(check.result);
  return fmt::format(
      R"(<tr class="{}"><th scope="row">{}</th><td class="num">{}</td><td class="num">{}</td>)"
      R"(<td class="result">{}</td><td><code>{}</code></td></tr>)"
      "\n",
      kClass[result], Escape(check.name), Escape(check.measured), Escape(check.target),
      kWord[result], Escape(check.key));
}

std::string Tile(const std::string& value, const std::string& label) {
  return fmt::format(R"(<div class="tile"><b>{}</b><span>{}</span></div>)"
                     "\n",
                     Escape(value), Escape(label));
}

/// Of walls, pipes and the robot itself.
std::string NearestTile(const Json& run) {
  double nearest = INFINITY;
  std::string to;
  const std::pair<const char*, const char*> kinds[] = {{"/min_clearance_m/plane", "walls"},
                                                       {"/min_clearance_m/pipe", "pipes"},
                                                       {"/min_clearance_m/self", "itself"}};
  for (const auto& [pointer, name] : kinds) {
    const Json* value = Find(run, pointer);
    if (value != nullptr && value->is_number() && value->get<double>() < nearest) {
      nearest = value->get<double>();
      to = name;
    }
  }
  return to.empty() ? Tile("–", "smallest clearance")
                    : Tile(WithUnit(1000 * nearest, "mm"), "smallest clearance, to " + to);
}

std::string NumberTile(const Json& run, const char* pointer, double scale, const char* unit,
                       const char* label) {
  const Json* value = Find(run, pointer);
  const bool there = value != nullptr && value->is_number();
  return Tile(there ? WithUnit(scale * value->get<double>(), unit) : "–", label);
}

std::string Words(const Json& run, const std::vector<Check>& checks) {
  const auto count = [&checks](Check::Result result) {
    return std::count_if(checks.begin(), checks.end(),
                         [result](const Check& c) { return c.result == result; });
  };
  const auto missed = count(Check::Result::kMissed);
  const auto unknown = count(Check::Result::kNotMeasured);
  std::string text =
      fmt::format("Not passed: {} of {} checks met", count(Check::Result::kMet), checks.size());
  if (missed + unknown == 0) {
    text = fmt::format("Passed: all {} checks met", checks.size());
  }
  if (unknown > 0) {
    text += fmt::format(", {} not measured", unknown);
  }
  const Json* stop = Find(run, "/stop_reason");
  const Json* detail = Find(run, "/stop_detail");
  const bool has_stop = stop != nullptr && stop->is_string();
  std::string reason = "Mission without a result";
  if (has_stop && *stop == "running") {
    reason = "Mission under way, or cut off before its figures were written";
  } else if (has_stop) {
    reason = (*stop == "complete" ? "Mission " : "Mission stopped: ") + stop->get<std::string>();
  }
  if (detail != nullptr && detail->is_string() && !detail->get_ref<const std::string&>().empty()) {
    reason += " – " + detail->get<std::string>();
  }
  return fmt::format(R"(<p class="word">{}</p><p class="reason">{}</p>)", Escape(text),
                     Escape(reason));
}

}  // namespace

std::vector<Check> Checks(const Json& run) {
  std::vector<Check> checks = {MissionCheck(run)};
  for (const Rule& rule : kRules) {
    checks.push_back(Apply(rule, run));
  }
  return checks;
}

std::string RenderVerdict(const Json& run) {
  const std::vector<Check> checks = Checks(run);
  const bool met = std::all_of(checks.begin(), checks.end(),
                               [](const Check& c) { return c.result == Check::Result::kMet; });
  std::string html = fmt::format("<div class=\"verdict {}\">{}</div>\n<div class=\"tiles\">\n",
                                 met ? "met" : "missed", Words(run, checks));
  html += NumberTile(run, "/coverage/ratio", 100, "%", "of the coverable surface covered");
  html += NumberTile(run, "/contacts", 1, "", "contacts");
  html += NearestTile(run);
  html += NumberTile(run, "/sim_time_s", 1, "s", "simulated");
  html += NumberTile(run, "/path/base_m", 1, "m", "driven");
  html +=
      "</div>\n<div class=\"scroll\"><table class=\"checks\"><thead><tr><th>Check</th>"
      "<th class=\"num\">Measured</th><th class=\"num\">Target</th><th>Result</th>"
      "<th>In run.json</th></tr></thead><tbody>\n";
  for (const Check& check : checks) {
    html += Row(check);
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace pipewright::hil
