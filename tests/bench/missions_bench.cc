// SPDX-License-Identifier: MIT
// Whole missions in virtual time, each `pipewright inspect` in a process of its own: whether any
// touches something, completes, and knows where it is. A crash takes one mission with it, not all.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdlib>
#include <set>
#include <thread>

#include "tests/bench/mission_campaign.h"

namespace pipewright::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kBadInput = 2;  ///< exit code

struct Options {
  CampaignOptions campaign;
  std::string out;  ///< empty: a temporary folder
  bool json = false;
};

/// Per scenario, then in all.
std::vector<std::pair<std::string, Json>> Summaries(const CampaignOptions& options,
                                                    const std::vector<MissionRun>& runs) {
  std::vector<std::pair<std::string, Json>> summaries;
  for (const std::string& scenario : options.scenarios) {
    std::vector<MissionRun> those;
    std::copy_if(runs.begin(), runs.end(), std::back_inserter(those),
                 [&](const MissionRun& run) { return run.scenario == Stem(scenario); });
    summaries.emplace_back(Stem(scenario), Summary(those));
  }
  summaries.emplace_back("all", Summary(runs));
  return summaries;
}

void Print(const Campaign& campaign, const std::vector<std::pair<std::string, Json>>& summaries) {
  fmt::print("\n{}", SummaryHead());
  for (const auto& [name, summary] : summaries) {
    fmt::print("{}", SummaryLine(name, summary));
  }
  fmt::print(
      "in missions: with a contact, of those that tell (not crashed, not cut short)\n"
      "rate: of missions with a contact, exact 95 % bound (Clopper-Pearson, one-sided)\n"
      "worst, end: error of the base's pose, largest in a mission and at its end; median / max\n");
  if (campaign.not_started() > 0) {
    fmt::print("not started: {}\n", campaign.not_started());
  }
  for (const MissionRun& run : campaign.runs()) {
    if (run.stop == "crashed" || run.stop == "refused" || run.contacts > 0) {
      fmt::print("{} seed {}: {}\n", run.scenario, run.seed,
                 run.contacts > 0 ? fmt::format("{} contacts", run.contacts)
                                  : run.stop + ": " + run.detail);
    }
  }
}

void PrintJson(const CampaignOptions& options, const Campaign& campaign,
               const std::vector<std::pair<std::string, Json>>& summaries) {
  Json out{{"faults", options.faults ? Json(Stem(*options.faults)) : Json(nullptr)},
           {"seeds", {options.first_seed, options.last_seed}},
           {"not_started", campaign.not_started()},
           {"missions", Json::array()},
           {"summary", Json::object()}};
  for (const MissionRun& run : campaign.runs()) {
    out["missions"].push_back(ToJson(run));
  }
  for (const auto& [name, summary] : summaries) {
    out["summary"][name] = summary;
  }
  fmt::print("{}\n", out.dump(2));
}

int RunAll(const Options& options) {
  std::string folder = options.out;
  std::error_code error;
  if (folder.empty()) {
    folder = (fs::temp_directory_path() / "pipewright_missions_XXXXXX").string();
    static_cast<void>(mkdtemp(folder.data()));  // else it is missing below
  } else {
    fs::create_directories(folder, error);
  }
  if (!fs::is_directory(folder, error)) {
    fmt::print(stderr, "bench_missions: cannot make the folder {}\n", folder);
    return kBadInput;
  }
  Campaign campaign(options.campaign, folder, !options.out.empty());
  campaign.Run(options.json ? stderr : stdout);
  if (options.out.empty()) {
    fs::remove_all(folder, error);
  }
  const auto summaries = Summaries(options.campaign, campaign.runs());
  if (options.json) {
    PrintJson(options.campaign, campaign, summaries);
  } else {
    Print(campaign, summaries);
  }
  const Json& all = summaries.back().second;
  const bool well = all["contacts"] == 0 && all["crashed"] == 0;
  return campaign.refused() ? kBadInput : well ? 0 : 1;
}

/// "A-B" or "A".
void TakeSeeds(const std::string& text, CampaignOptions& options) {
  const char* const end = text.data() + text.size();
  std::from_chars_result read = std::from_chars(text.data(), end, options.first_seed);
  options.last_seed = options.first_seed;
  if (read.ec == std::errc() && read.ptr != end && *read.ptr == '-') {
    read = std::from_chars(read.ptr + 1, end, options.last_seed);
  }
  if (read.ec != std::errc() || read.ptr != end || options.last_seed < options.first_seed ||
      options.last_seed - options.first_seed >= 100000) {
    throw CLI::ValidationError("--seeds", text + " is not A-B with A <= B, 100000 at most");
  }
}

/// The evidence, and the summary, go by the scenarios' names.
void CheckNames(const CampaignOptions& options) {
  std::set<std::string> names;
  for (const std::string& scenario : options.scenarios) {
    if (!names.insert(Stem(scenario)).second) {
      throw CLI::ValidationError("--scenarios", "two are called " + Stem(scenario));
    }
  }
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  pipewright::bench::Options options;
  options.campaign.jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  CLI::App app("Whole missions in virtual time, each in a process of its own", "bench_missions");
  app.add_option("--scenarios", options.campaign.scenarios, "names or files, with commas between")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--seeds",
         [&options](const std::string& text) {
           pipewright::bench::TakeSeeds(text, options.campaign);
         },
         "A-B, of each scenario")
      ->default_str("1-10");
  app.add_option("--faults", options.campaign.faults,
                 "laid over each scenario: a name or a file, as pipewright inspect takes them");
  app.add_option("--jobs", options.campaign.jobs, "missions at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--out", options.out, "keep the evidence here, a folder a mission");
  app.add_flag("--json", options.json, "one JSON object on stdout");
  app.footer(
      "Exit code: 0 no mission touched anything or crashed; 1 one did; 2 the input is bad.\n"
      "Ctrl-C ends the missions that run, and still prints the summary.");
  try {
    app.parse(argc, argv);
    pipewright::bench::CheckNames(options.campaign);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return pipewright::bench::RunAll(options);
}
