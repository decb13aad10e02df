// SPDX-License-Identifier: MIT
#include "hil/report/figure_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "hil/report/markup.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kShownItems = 8;  ///< of a list

struct Known {
  std::string_view key;
  std::string_view unit;  ///< "" when the key's suffix says it
  std::string_view meaning;
  bool wall_clock = false;
};

constexpr Known kKnown[] = {
    {"scenario", "", "the world that was inspected"},
    {"faults", "", "laid over it: what went wrong besides"},
    {"seed", "", "of sensor noise and planning"},
    {"planner", "", "what chose the views"},
    {"stop_reason", "", "why the mission ended"},
    {"stop_detail", "", "the device or sensor at fault, if any"},
    {"sim_time_s", "", "length of the mission"},
    {"wall_time_s", "", "time it took on this machine", true},
    {"contacts", "", "times that a body of the robot touched something (truth)"},
    {"touched", "", "what it touched"},
    {"voxels.total", "voxels", "in the workspace"},
    {"voxels.free", "voxels", "seen empty"},
    {"voxels.occupied", "voxels", "seen occupied"},
    {"voxels.unknown", "voxels", "never seen"},
    {"voxels.residual", "voxels", "given up: no view of them can be reached"},
    {"voxels.covered", "voxels", "occupied and covered by the probe"},
    {"coverage.truth_surface", "voxels", "of true surface in the workspace"},
    {"coverage.truth_coverable", "voxels", "of these, which the probe can cover at all"},
    {"coverage.truth_covered", "voxels", "of these, which it covered"},
    {"coverage.ratio", "%", "covered of coverable"},
    {"coverage.time_to_95_percent_s", "", "until 95 % were covered"},
    {"coverage.missed_voxels", "", "coverable ones that were not covered"},
    {"entropy.visual", "nats per voxel", "what is left to see"},
    {"entropy.coverage", "nats per voxel", "what is left to cover"},
    {"entropy.combined", "nats per voxel", "their sum"},
    {"min_clearance_m.plane", "m", "to walls, floor and boxes (truth)"},
    {"min_clearance_m.pipe", "m", "to pipes and meshes (truth)"},
    {"min_clearance_m.self", "m", "between parts of the robot (truth)"},
    {"svfi.mode", "", "velocity at which deviations are taken"},
    {"svfi.alpha", "", "probability with which each constraint is to hold"},
    {"svfi.joint_risk", "", "that of all constraints of a cycle together"},
    {"svfi.checked", "", "chance constraints checked against what was sent"},
    {"svfi.held", "", "of these, met"},
    {"svfi.ratio", "%", "met of checked"},
    {"svfi.fallbacks", "", "cycles that fell back to the worst case"},
    {"svfi.out_of_reach", "", "cycles in which braking could not meet every constraint at once"},
    {"control.rate_hz", "", "of the control task"},
    {"control.cycles", "", "control cycles"},
    {"control.heap_allocations", "", "inside control cycles"},
    {"control.rows_max", "", "most constraint rows in one QP"},
    {"control.qp_iterations_max", "", "most in one cycle"},
    {"control.qp_cap_hits", "", "cycles that ended at the iteration cap"},
    {"control.qp_us", "", "time of the QP", true},
    {"control.cycle_us", "", "time of a whole cycle", true},
    {"control.lateral_speed_max_mps", "", "of the base across its heading"},
    {"control.joint_limit_excess_rad", "", "largest; below zero: never passed"},
    {"control.joint_hard_stops", "", "times that a joint ran into its end"},
    {"plan.steps", "", "planning steps"},
    {"plan.stalls", "", "goals given up on the way"},
    {"plan.step_ms", "", "time of a planning step", true},
    {"path.base_m", "", "driven by the base"},
    {"path.joint_rad", "", "turned by all joints together"},
    {"localization.error_max_m", "", "of the base's position"},
    {"localization.error_max_deg", "°", "of its heading"},
    {"localization.error_final_m", "", "of the base's position at the end"},
    {"localization.error_final_deg", "°", "of its heading at the end"},
    {"localization.wheels_error_max_m", "", "of the position that the wheels alone tell"},
    {"localization.wheels_error_max_deg", "°", "of the heading that they tell"},
    {"localization.slip", "", "of the floor at the end, over a usual one's"},
    {"localization.yaw_scale_slow", "", "the base's turn over that of its wheels, up to 0.3 rad/s"},
    {"localization.yaw_scale_fast", "", "the same from 0.6 rad/s on"},
    {"localization.way_scale", "", "its way over that of its wheels"},
    {"localization.fixes", "", "scans that corrected the pose"},
    {"localization.fixes_refused", "", "scans beyond the filter's gate, or that fit nowhere"},
    {"localization.doubts", "", "times that the robot stood, for scans and pose disagreed"},
    {"localization.slips", "", "of these, the pose was wrong and moved to where scans have it"},
    {"localization.frames_doubted", "", "frames of which no map took anything"},
    {"localization.surfel_repairs", "",
     "times that surfels which frames contradict were forgotten"},
    {"localization.depth_noise_1pm", "1/m", "depth noise over depth squared, as measured"},
    {"can.tx", "frames", "sent by the robot"},
    {"can.rx", "frames", "received by the robot"},
    {"can.dropped", "frames", "lost in full queues"},
    {"can.load_peak", "%", "largest load of a bus over a second"},
};

struct Suffix {
  std::string_view suffix;
  std::string_view unit;
};

constexpr Suffix kSuffixes[] = {
    {"_mps", "m/s"}, {"_radps", "rad/s"}, {"_rad", "rad"}, {"_hz", "Hz"},
    {"_us", "µs"},   {"_ms", "ms"},       {"_m", "m"},     {"_s", "s"},
};

/// What is known of a key; else of the object that it is in ("control.qp_us" of its p50).
Known Lookup(const std::string& key) {
  const std::string parent = key.substr(0, key.rfind('.'));
  for (const std::string& name : {key, parent}) {
    for (const Known& known : kKnown) {
      if (known.key == name) {
        return known;
      }
    }
  }
  return {};
}

/// By the key's suffix, or that of the object that it is in.
std::string_view UnitOf(const std::string& key) {
  const std::string parent = key.substr(0, key.rfind('.'));
  for (const std::string& name : {key, parent}) {
    for (const Suffix& s : kSuffixes) {
      if (name.ends_with(s.suffix)) {
        return s.unit;
      }
    }
  }
  return "";
}

std::string ValueText(const Json& value, const Known& known);

/// "a, b, (1, 2)"; of many the first few and their number.
std::string ListText(const Json& list, const Known& known) {
  std::string text;
  for (std::size_t i = 0; i < std::min(list.size(), kShownItems); ++i) {
    const std::string item = ValueText(list[i], known);
    text += text.empty() ? "" : ", ";
    text += list[i].is_array() ? fmt::format("({})", item) : item;
  }
  if (list.size() > kShownItems) {
    text += fmt::format(" … {} in all", list.size());
  }
  return text.empty() ? "none" : text;
}

std::string ValueText(const Json& value, const Known& known) {
  if (value.is_number()) {
    return Number((known.unit == "%" ? 100 : 1) * value.get<double>());
  }
  if (value.is_null()) {
    return "–";
  }
  if (value.is_string()) {
    return value.get_ref<const std::string&>().empty() ? "–" : value.get<std::string>();
  }
  if (value.is_array()) {
    return ListText(value, known);
  }
  return value.dump();
}

void AddRows(std::string& html, const std::string& key, const Json& value) {
  if (value.is_object()) {
    for (const auto& [name, item] : value.items()) {
      AddRows(html, fmt::format("{}.{}", key, name), item);
    }
    return;
  }
  Known known = Lookup(key);
  if (known.unit.empty()) {
    known.unit = UnitOf(key);
  }
  html += fmt::format(
      R"(<tr{}><th scope="row"><code>{}</code></th><td class="num">{}</td><td>{}</td><td>{}</td></tr>)"
      "\n",
      known.wall_clock ? R"( class="wall")" : "", Escape(key), Escape(ValueText(value, known)),
      Escape(known.unit), Escape(known.meaning));
}

std::string Table(const std::string& title, const std::string& rows) {
  return fmt::format("<table class=\"figures\"><caption>{}</caption><tbody>\n{}</tbody></table>\n",
                     Escape(title), rows);
}

}  // namespace

std::string RenderFigureTables(const Json& run) {
  if (!run.is_object()) {
    return "<p>No figures were written.</p>\n";
  }
  std::string top;
  std::string tables;
  for (const auto& [name, value] : run.items()) {
    if (value.is_object()) {
      std::string rows;
      AddRows(rows, name, value);
      tables += Table(name, rows);
    } else {
      AddRows(top, name, value);
    }
  }
  return Table("run", top) + tables;
}

}  // namespace pipewright::hil
