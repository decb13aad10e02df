// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace pipewright::bench {

/// How one mission went, as far as it got.
struct MissionRun {
  std::string scenario;
  std::uint64_t seed = 0;
  std::string stop;    ///< run.json's stop_reason, else "crashed", "refused" or "interrupted"
  std::string detail;  ///< in words, empty for a complete one
  bool read = false;   ///< run.json was there and whole; else what follows is 0, but wall_s
  double sim_s = 0;
  int contacts = 0;
  double coverage = 0;     ///< of what the probe can cover, in [0, 1]
  double error_max_m = 0;  ///< of the base's pose that the robot moves by, each largest
  double error_max_deg = 0;
  double error_final_m = 0;
  double error_final_deg = 0;
  std::uint64_t heap_allocations = 0;  ///< inside control cycles
  double wall_s = 0;

  /// Whether it says something of how often robots touch: one that was cut short may not have come
  /// to it, unless it has.
  bool tells() const { return read && (stop != "interrupted" || contacts > 0); }
};

/// Takes over the figures of run.json. Leaves `run` unread when there is none, or not a whole one.
void ReadRun(const std::filesystem::path& run_json, MissionRun& run);

nlohmann::ordered_json ToJson(const MissionRun& run);

/// The largest rate of events at which n independent trials show k or fewer with a probability of
/// 5 % at least: the exact one-sided 95 % bound of Clopper and Pearson. For k = 0 about 3/n; 1 for
/// no trial.
double RateBound95(int k, int n);

/// Counts, the bound of the rate of contacts, and the spread of the pose errors.
nlohmann::ordered_json Summary(const std::vector<MissionRun>& runs);

/// A line for a mission, and one for Summary()'s object, below their heads.
std::string RunHead();
std::string RunLine(const MissionRun& run, std::size_t left);
std::string SummaryHead();
std::string SummaryLine(const std::string& name, const nlohmann::ordered_json& summary);

}  // namespace pipewright::bench
