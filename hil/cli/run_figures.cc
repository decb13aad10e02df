// SPDX-License-Identifier: MIT
#include "hil/cli/run_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hil/cli/program_record.h"
#include "hil/cli/table_rows.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

Json Spread(const std::vector<float>& values) {
  return {{"p50", Percentile(values, 0.5)},
          {"p99", Percentile(values, 0.99)},
          {"max", Percentile(values, 1)}};
}

/// JSON has no infinity: nothing was ever near.
Json Finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

double Share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

double Degrees(double rad) { return rad * 180 / std::numbers::pi; }

/// The coverable surface voxels that the probe missed, by their least corner's index.
Json Missed(const Truth& truth) {
  Json missed = Json::array();
  const SurfaceVoxels& surface = truth.surface();
  for (std::size_t i = 0; i < surface.voxels.size(); ++i) {
    if (truth.coverable().coverable[i] != 0 && truth.covered()[i] == 0) {
      missed.push_back(surface.voxels[i].index);
    }
  }
  return missed;
}

Json CoverageJson(const Truth& truth, double covered_95_s) {
  const Truth::Coverage coverage = truth.coverage();
  return {{"truth_surface", coverage.surface},
          {"truth_coverable", coverage.coverable},
          {"truth_covered", coverage.covered},
          {"ratio", coverage.ratio},
          {"time_to_95_percent_s", covered_95_s < 0 ? Json(nullptr) : Json(covered_95_s)},
          {"missed_voxels", Missed(truth)}};
}

Json ClearanceJson(const Truth& truth) {
  return {{"plane", Finite(truth.min_plane_m())},
          {"pipe", Finite(truth.min_pipe_m())},
          {"self", Finite(truth.min_self_m())}};
}

std::string Metres(const Json& value) {
  return value.is_null() ? "none near" : fmt::format("{:.3f} m", value.get<double>());
}

}  // namespace

void RunFigures::Add(const ControlReport& report) {
  const ControlStats& stats = report.stats;
  ++cycles;
  qp_iterations_max = std::max(qp_iterations_max, stats.qp.iterations);
  qp_cap_hits += stats.qp.status == QpStatus::kCapped;
  svfi_checked += static_cast<std::uint64_t>(stats.qp.checked);
  svfi_held += static_cast<std::uint64_t>(stats.qp.held);
  svfi_fallbacks += static_cast<std::uint64_t>(stats.qp.fallbacks);
  svfi_out_of_reach += stats.qp.out_of_reach ? 1 : 0;
  rows_max = std::max(rows_max, stats.rows);
  qp_us.push_back(1e-3F * static_cast<float>(stats.qp_ns));
}

double Percentile(std::vector<float> values, double p) {
  if (values.empty()) {
    return 0;
  }
  const double rank = std::ceil(p * static_cast<double>(values.size()));
  const auto k = static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

Json FaultsJson(const InspectionOptions& options) {
  return options.faults ? Json(NameOfConditions(*options.faults)) : Json(nullptr);
}

Json RunJson(const InspectionOptions& options, const Scenario& scenario,
             const RobotProgram& program, const Emulator* emulator, const RunFigures& figures,
             const CanFigures& can, Time end, const std::string& stop_detail) {
  const MissionOutput& mission = program.planning().output();
  const VoxelGrid& map = program.mapping().map();
  const MapCounts& counts = map.counts();
  /// A figure of the truth, which only the emulator has.
  const auto known = [emulator](const auto& figure) {
    return emulator != nullptr ? Json(figure(*emulator)) : Json(nullptr);
  };
  const auto measured = [emulator](double figure) {
    return emulator != nullptr ? Json(figure) : Json(nullptr);
  };
  Json run;
  run["scenario"] = scenario.name;
  run["faults"] = FaultsJson(options);
  run["seed"] = options.seed;
  run["planner"] = Name(options.planner);
  run["program"] = ProgramJson(scenario, options);
  run["stop_reason"] = Name(mission.stop);
  run["stop_detail"] = stop_detail;
  run["interrupted_s"] =
      figures.interrupted ? Json(ToSeconds(*figures.interrupted)) : Json(nullptr);
  run["sim_time_s"] = ToSeconds(end);
  run["wall_time_s"] = figures.wall_s;
  run["voxels"] = {{"total", counts.total},       {"free", counts.free},
                   {"occupied", counts.occupied}, {"unknown", counts.unknown},
                   {"residual", counts.residual}, {"covered", counts.covered}};
  run["coverage"] =
      known([&](const Emulator& e) { return CoverageJson(e.truth(), figures.covered_95_s); });
  run["entropy"] = {{"visual", map.visual_entropy()},
                    {"coverage", map.coverage_entropy()},
                    {"combined", map.combined_entropy()}};
  run["contacts"] = known([](const Emulator& e) { return e.truth().contacts(); });
  run["touched"] = known([](const Emulator& e) { return e.truth().touched(); });
  run["min_clearance_m"] = known([](const Emulator& e) { return ClearanceJson(e.truth()); });
  run["svfi"] = {{"mode", Name(options.svfi)},
                 {"alpha", options.alpha},
                 {"joint_risk", options.joint_risk},
                 {"checked", figures.svfi_checked},
                 {"held", figures.svfi_held},
                 {"ratio", Share(figures.svfi_held, figures.svfi_checked)},
                 {"fallbacks", figures.svfi_fallbacks},
                 {"out_of_reach", figures.svfi_out_of_reach}};
  run["control"] = {
      {"rate_hz", options.rate_hz},
      {"cycles", figures.cycles},
      {"heap_allocations", figures.heap_allocations},
      {"rows_max", figures.rows_max},
      {"qp_iterations_max", figures.qp_iterations_max},
      {"qp_cap_hits", figures.qp_cap_hits},
      {"qp_us", Spread(figures.qp_us)},
      {"cycle_us", Spread(figures.cycle_us)},
      {"lateral_speed_max_mps", known([](const Emulator& e) { return e.lateral_speed_max_mps(); })},
      {"joint_limit_excess_rad", measured(figures.joint_limit_excess_rad)},
      {"joint_hard_stops", known([](const Emulator& e) { return e.plant().hard_stops(); })}};
  run["plan"] = {{"steps", mission.plan_steps},
                 {"stalls", mission.stalls},
                 {"step_ms", Spread(figures.step_ms)}};
  run["path"] = {{"base_m", known([](const Emulator& e) { return e.base_travel_m(); })},
                 {"joint_rad", known([](const Emulator& e) { return e.joint_travel_rad(); })}};
  const PoseReport& pose = program.control().report().pose;
  run["localization"] = {{"error_max_m", measured(figures.pose_max.m)},
                         {"error_max_deg", measured(Degrees(figures.pose_max.rad))},
                         {"error_final_m", measured(figures.pose_final.m)},
                         {"error_final_deg", measured(Degrees(figures.pose_final.rad))},
                         {"wheels_error_max_m", measured(figures.wheels_max.m)},
                         {"wheels_error_max_deg", measured(Degrees(figures.wheels_max.rad))},
                         {"slip", pose.slip},
                         {"yaw_scale_slow", pose.yaw_scale_slow},
                         {"yaw_scale_fast", pose.yaw_scale_fast},
                         {"way_scale", pose.way_scale},
                         {"fixes", pose.fixes},
                         {"fixes_refused", pose.refused},
                         {"doubts", pose.doubts},
                         {"slips", pose.slips},
                         {"surfel_repairs", program.mapping().localizer().counters().repairs},
                         {"depth_noise_1pm", program.mapping().noise().k_1pm()},
                         {"frames_doubted", program.mapping().counters().doubted}};
  run["can"] = {
      {"tx", can.tx}, {"rx", can.rx}, {"dropped", can.dropped}, {"load_peak", can.load_peak}};
  return run;
}

Json PlanJson(Time now, const MissionOutput& output, const Goal& goal, const MapCounts& counts) {
  const PlanNumbers& n = output.numbers;
  Json step;
  step["t_s"] = ToSeconds(now);
  step["step"] = output.plan_steps;
  step["decision"] = Name(output.decision);
  if (output.decision == PlanDecision::kGoal) {
    step["goal"] = {{"id", goal.id},
                    {"p_WS", {goal.p_WS.x(), goal.p_WS.y(), goal.p_WS.z()}},
                    {"z_WS", {goal.z_WS.x(), goal.z_WS.y(), goal.z_WS.z()}},
                    {"waypoints", goal.path.size()}};
  }
  step["candidates"] = n.candidates;
  step["reachable"] = n.reachable;
  step["paths_tried"] = n.paths_tried;
  step["gain"] = {
      {"visual", n.gain_visual}, {"coverage", n.gain_coverage}, {"weighted", n.gain_weighted}};
  step["duration_s"] = n.duration_s;
  step["left"] = {{"unknown", n.unknown_targets},
                  {"uncovered", n.uncovered_targets},
                  {"given_up", n.given_up},
                  {"residual_new", n.residual_new}};
  if (output.decision == PlanDecision::kComplete) {
    step["stopping"] = {{"tested", n.tested}, {"share_bound", n.share_bound}};
  }
  step["voxels"] = {{"free", counts.free},
                    {"occupied", counts.occupied},
                    {"unknown", counts.unknown},
                    {"residual", counts.residual},
                    {"covered", counts.covered}};
  return step;
}

std::string RunTable(const Json& run, const std::string& folder) {
  const Json& coverage = run["coverage"];
  const Json& clear = run["min_clearance_m"];
  const Json& control = run["control"];
  const Json& can = run["can"];
  const double sim_s = run["sim_time_s"];
  const double wall_s = run["wall_time_s"];
  TableRows row;
  const std::string detail = run["stop_detail"];
  row("result", fmt::format("{}{}", run["stop_reason"].get<std::string>(),
                            detail.empty() ? "" : ": " + detail));
  if (run["contacts"].is_null()) {
    row("truth", "known where the devices are");
  } else {
    row("coverage",
        fmt::format("{:.1f} % ({} of {} coverable surface voxels)",
                    100 * coverage["ratio"].get<double>(), coverage["truth_covered"].get<int>(),
                    coverage["truth_coverable"].get<int>()));
    row("contacts", fmt::format("{}", run["contacts"].get<int>()));
    row("clearance", fmt::format("walls {}, pipes {}, itself {}", Metres(clear["plane"]),
                                 Metres(clear["pipe"]), Metres(clear["self"])));
  }
  row("time", fmt::format("{:.1f} s simulated in {:.1f} s ({:.1f}x)", sim_s, wall_s,
                          wall_s > 0 ? sim_s / wall_s : 0));
  row("planning", fmt::format("{} steps, {:.0f} ms median", run["plan"]["steps"].get<int>(),
                              run["plan"]["step_ms"]["p50"].get<double>()));
  row("control",
      fmt::format("{} cycles, p99 {:.0f} us, {} allocations",
                  control["cycles"].get<std::uint64_t>(), control["cycle_us"]["p99"].get<double>(),
                  control["heap_allocations"].get<std::uint64_t>()));
  row("bus",
      fmt::format("{} frames out, {} in, {} dropped, load {:.0f} %", can["tx"].get<std::uint64_t>(),
                  can["rx"].get<std::uint64_t>(), can["dropped"].get<std::uint64_t>(),
                  100 * can["load_peak"].get<double>()));
  row("evidence", folder);
  return row.text;
}

bool Passed(const Json& run) {
  const bool touched = run["contacts"] != nullptr && run["contacts"] != 0;
  return run["stop_reason"] == "complete" && !touched && run["control"]["heap_allocations"] == 0;
}

}  // namespace pipewright::hil
