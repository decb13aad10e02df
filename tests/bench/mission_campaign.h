// SPDX-License-Identifier: MIT
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/mission_figures.h"

namespace pipewright::bench {

struct CampaignOptions {
  std::vector<std::string> scenarios = {"pipes1", "pipes2", "pipes3"};  ///< no two of one Stem()
  std::uint64_t first_seed = 1;
  std::uint64_t last_seed = 10;
  std::optional<std::string> faults;
  int jobs = 1;  ///< missions at a time
};

/// What a scenario or faults are called: the shipped name, or the file's.
std::string Stem(const std::string& name_or_file);

/// Missions of `pipewright inspect`, from beside this program, each in a process of its own: a
/// crash takes one with it, not all. Keeps how each went.
class Campaign {
 public:
  /// @param folder  takes a folder and a log a mission
  /// @param keep    whether these are left when a mission has ended
  Campaign(const CampaignOptions& options, const std::filesystem::path& folder, bool keep);

  /// @param to  takes a line a mission as it ends
  /// Ends early on SIGINT and SIGTERM, which from then on are blocked.
  void Run(std::FILE* to);
  const std::vector<MissionRun>& runs() const { return runs_; }
  std::size_t not_started() const { return not_started_; }
  /// Whether a mission's input was bad. Then the others' is: they are stopped.
  bool refused() const { return refused_; }

 private:
  struct Mission {
    MissionRun run;
    std::string scenario;  ///< as given
    std::chrono::steady_clock::time_point start;
    std::filesystem::path folder;
    std::filesystem::path log;  ///< of stderr; beside the folder, which is the run's alone
  };

  void Start(Mission mission);
  void End(Mission& mission, int status);
  void Stop();

  std::vector<std::string> faults_;  ///< as arguments
  std::size_t jobs_ = 1;
  bool keep_ = false;             ///< the evidence
  std::vector<Mission> waiting_;  ///< the next one last
  std::map<pid_t, Mission> running_;
  std::vector<MissionRun> runs_;  ///< in the order in which they ended
  std::size_t not_started_ = 0;   ///< because it was to end early
  bool stopping_ = false;
  bool refused_ = false;
};

}  // namespace pipewright::bench
