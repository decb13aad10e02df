// SPDX-License-Identifier: MIT
#include "tests/bench/mission_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;

/// Median and largest of one figure over the missions that ran to their end.
Json Spread(const std::vector<MissionRun>& runs, double MissionRun::*figure, double scale) {
  std::vector<double> values;
  for (const MissionRun& run : runs) {
    if (run.read && run.stop != "interrupted") {
      values.push_back(scale * run.*figure);
    }
  }
  if (values.empty()) {
    return {{"median", nullptr}, {"max", nullptr}};
  }
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return {{"median", (values[(n - 1) / 2] + values[n / 2]) / 2}, {"max", values.back()}};
}

std::string SpreadText(const Json& spread, int digits) {
  return spread["max"].is_null() ? "-"
                                 : fmt::format("{:.{}f} / {:.{}f}", spread["median"].get<double>(),
                                               digits, spread["max"].get<double>(), digits);
}

}  // namespace

void ReadRun(const std::filesystem::path& run_json, MissionRun& run) {
  std::ifstream file(run_json);
  const Json json = Json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) {
    run.detail = "no run.json, or a torn one";
    return;
  }
  try {
    MissionRun got = run;
    json.at("stop_reason").get_to(got.stop);
    json.at("stop_detail").get_to(got.detail);
    json.at("sim_time_s").get_to(got.sim_s);
    json.at("contacts").get_to(got.contacts);
    json.at("coverage").at("ratio").get_to(got.coverage);
    const Json& pose = json.at("localization");
    pose.at("error_max_m").get_to(got.error_max_m);
    pose.at("error_max_deg").get_to(got.error_max_deg);
    pose.at("error_final_m").get_to(got.error_final_m);
    pose.at("error_final_deg").get_to(got.error_final_deg);
    json.at("control").at("heap_allocations").get_to(got.heap_allocations);
    got.read = true;
    run = got;
  } catch (const Json::exception& error) {
    run.detail = fmt::format("run.json: {}", error.what());
  }
}

Json ToJson(const MissionRun& run) {
  Json json{{"scenario", run.scenario},
            {"seed", run.seed},
            {"stop_reason", run.stop},
            {"stop_detail", run.detail}};
  if (run.read) {
    json.update({{"sim_time_s", run.sim_s},
                 {"contacts", run.contacts},
                 {"coverage_ratio", run.coverage},
                 {"error_max_mm", 1e3 * run.error_max_m},
                 {"error_max_deg", run.error_max_deg},
                 {"error_final_mm", 1e3 * run.error_final_m},
                 {"error_final_deg", run.error_final_deg},
                 {"heap_allocations", run.heap_allocations}});
  }
  json["wall_time_s"] = run.wall_s;
  return json;
}

double RateBound95(int k, int n) {
  if (k >= n) {
    return 1;
  }
  const auto at_most_k = [k, n](double p) {
    double sum = 0;
    for (int i = 0; i <= k; ++i) {
      const double ways = std::lgamma(n + 1) - std::lgamma(i + 1) - std::lgamma(n - i + 1);
      sum += std::exp(ways + i * std::log(p) + (n - i) * std::log1p(-p));
    }
    return sum;
  };
  double lo = 0;
  double hi = 1;
  for (int i = 0; i < 60; ++i) {  // at_most_k falls from 1 to 0
    const double p = (lo + hi) / 2;
    (at_most_k(p) > 0.05 ? lo : hi) = p;
  }
  return hi;
}

Json Summary(const std::vector<MissionRun>& runs) {
  std::map<std::string, int> stopped;
  int tell = 0;
  int touched = 0;
  int contacts = 0;
  std::uint64_t heap_allocations = 0;
  for (const MissionRun& run : runs) {
    ++stopped[run.stop];
    tell += run.tells() ? 1 : 0;
    touched += run.contacts > 0 ? 1 : 0;
    contacts += run.contacts;
    heap_allocations += run.heap_allocations;
  }
  return {{"missions", runs.size()},
          {"complete", stopped["complete"]},
          {"crashed", stopped["crashed"]},
          {"stopped", stopped},
          {"contacts", contacts},
          {"missions_with_contact", touched},
          {"missions_that_tell", tell},
          {"contact_rate_bound95", RateBound95(touched, tell)},
          {"heap_allocations", heap_allocations},
          {"error_max_mm", Spread(runs, &MissionRun::error_max_m, 1e3)},
          {"error_max_deg", Spread(runs, &MissionRun::error_max_deg, 1)},
          {"error_final_mm", Spread(runs, &MissionRun::error_final_m, 1e3)},
          {"error_final_deg", Spread(runs, &MissionRun::error_final_deg, 1)}};
}

std::string RunHead() {
  return fmt::format("{:<12} {:>6} {:<17} {:>7} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>6} {:>7}\n",
                     "scenario", "seed", "stopped by", "sim s", "contacts", "covered", "worst mm",
                     "worst deg", "end mm", "end deg", "allocs", "wall s");
}

std::string RunLine(const MissionRun& run, std::size_t left) {
  std::string line = fmt::format("{:<12} {:>6} {:<17} ", run.scenario, run.seed, run.stop);
  line += run.read
              ? fmt::format("{:>7.1f} {:>8} {:>7.1f} % {:>9.1f} {:>9.2f} {:>9.1f} {:>9.2f} {:>6}",
                            run.sim_s, run.contacts, 100 * run.coverage, 1e3 * run.error_max_m,
                            run.error_max_deg, 1e3 * run.error_final_m, run.error_final_deg,
                            run.heap_allocations)
              : std::string(69, ' ');
  line += fmt::format(" {:>7.1f}  {} left", run.wall_s, left);
  return line + (run.read ? "" : "  " + run.detail) + "\n";
}

std::string SummaryHead() {
  return fmt::format(
      "{:<12} {:>5} {:>8} {:>8} {:>11} {:>7} {:>15} {:>13} {:>15} {:>13} {:>6}  {}\n", "", "N",
      "complete", "contacts", "in missions", "rate <=", "worst mm", "worst deg", "end mm",
      "end deg", "allocs", "stopped by");
}

std::string SummaryLine(const std::string& name, const Json& s) {
  std::string stopped;
  for (const auto& [why, count] : s["stopped"].items()) {
    if (count > 0) {
      stopped += fmt::format("{}{} {}", stopped.empty() ? "" : ", ", why, count.get<int>());
    }
  }
  const std::string touched = fmt::format("{} of {}", s["missions_with_contact"].get<int>(),
                                          s["missions_that_tell"].get<int>());
  return fmt::format(
      "{:<12} {:>5} {:>8} {:>8} {:>11} {:>5.1f} % {:>15} {:>13} {:>15} {:>13} {:>6}  {}\n", name,
      s["missions"].get<int>(), s["complete"].get<int>(), s["contacts"].get<int>(), touched,
      100 * s["contact_rate_bound95"].get<double>(), SpreadText(s["error_max_mm"], 1),
      SpreadText(s["error_max_deg"], 2), SpreadText(s["error_final_mm"], 1),
      SpreadText(s["error_final_deg"], 2), s["heap_allocations"].get<std::uint64_t>(), stopped);
}

}  // namespace pipewright::bench
