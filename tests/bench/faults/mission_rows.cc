// SPDX-License-Identifier: MIT
// F17 and F18: whole missions with a camera and a floor at fault.
#include <fmt/format.h>
#include <stdlib.h>

#include <cstdio>
#include <filesystem>

#include "tests/bench/faults/rows.h"
#include "tests/bench/mission_campaign.h"

namespace pipewright::bench {

Tally MissionsUnderFaults(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  std::string folder =
      (std::filesystem::temp_directory_path() / "pipewright_faults_XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) {
    tally.Add(Outcome::kCrash);
    tally.Note("no temporary folder");
    return tally;
  }
  CampaignOptions options;
  options.faults = "rough";
  options.first_seed = seed;
  options.last_seed = seed + (n + options.scenarios.size() - 1) / options.scenarios.size() - 1;
  Campaign campaign(options, folder, /*keep=*/false);
  campaign.Run(stderr);
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  for (const MissionRun& run : campaign.runs()) {
    const bool wrong = run.contacts > 0 || run.heap_allocations > 0;
    tally.Add(!run.read                ? Outcome::kCrash
              : wrong                  ? Outcome::kWrong
              : run.stop == "complete" ? Outcome::kMasked
                                       : Outcome::kSafeStop);
    if (wrong || !run.read) {
      tally.Note(fmt::format("{} seed {}: {} contacts, {} {}", run.scenario, run.seed, run.contacts,
                             run.stop, run.detail));
    }
  }
  tally.Note("for many: scripts/bench missions --seeds 1-334 --faults rough");
  return tally;
}

}  // namespace pipewright::bench
