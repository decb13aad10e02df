// SPDX-License-Identifier: MIT
// Beside this test lies a stand-in for pipewright, whose scenario says how the mission goes.
#include "tests/bench/mission_campaign.h"

#include <gtest/gtest.h>

#include "tests/support/command.h"

namespace pipewright::bench {
namespace {

namespace fs = std::filesystem;

/// What it prints.
std::string RunAll(Campaign* campaign) {
  std::FILE* const to = std::tmpfile();
  campaign->Run(to);
  std::string text(static_cast<std::size_t>(std::ftell(to)), '\0');
  std::rewind(to);
  EXPECT_EQ(std::fread(text.data(), 1, text.size(), to), text.size());
  std::fclose(to);
  return text;
}

CampaignOptions Options(const std::vector<std::string>& scenarios) {
  CampaignOptions options;
  options.scenarios = scenarios;
  options.last_seed = options.first_seed;
  return options;
}

TEST(Campaign, TellsACrashFromAMissionThatEnded) {
  const struct {
    const char* scenario;
    const char* stop;
    int contacts;
    bool read;
    const char* detail;
  } cases[] = {
      {"complete", "complete", 0, true, "complete 0"},
      {"touches", "timeout", 2, true, "timeout 2"},
      {"torn", "crashed", 0, false, "exit code 1: no run.json, or a torn one"},
      {"silent", "crashed", 0, false, "exit code 1: no run.json, or a torn one"},
      {"killed", "crashed", 0, false, "signal 9: the last words"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.scenario);
    Campaign campaign(Options({c.scenario}), test::TestFolder(), /*keep=*/false);
    const std::string printed = RunAll(&campaign);
    ASSERT_EQ(campaign.runs().size(), 1U);
    const MissionRun& run = campaign.runs()[0];
    EXPECT_EQ(run.stop, c.stop);
    EXPECT_EQ(run.contacts, c.contacts);
    EXPECT_EQ(run.read, c.read);
    EXPECT_EQ(run.detail, c.detail);
    EXPECT_FALSE(campaign.refused());
    EXPECT_NE(printed.find(c.stop), std::string::npos);
  }
}

TEST(Campaign, RunsEverySeedOfEveryScenarioOnceAndACrashStopsNone) {
  CampaignOptions options = Options({"complete", "killed", "touches"});
  options.first_seed = 4;
  options.last_seed = 8;
  options.jobs = 4;
  Campaign campaign(options, test::TestFolder(), /*keep=*/false);
  RunAll(&campaign);
  std::map<std::pair<std::string, std::uint64_t>, int> seen;
  for (const MissionRun& run : campaign.runs()) {
    ++seen[{run.scenario, run.seed}];
  }
  EXPECT_EQ(campaign.runs().size(), 15U);
  EXPECT_EQ(seen.size(), 15U);
  EXPECT_TRUE(seen.contains({"killed", 8}));
  EXPECT_EQ(campaign.not_started(), 0U);
}

TEST(Campaign, KeepsTheEvidenceOnlyWhenAsked) {
  for (const bool keep : {true, false}) {
    const fs::path folder = test::TestFolder();
    CampaignOptions options = Options({"faulty"});
    options.faults = "rough";
    Campaign campaign(options, folder, keep);
    RunAll(&campaign);
    EXPECT_EQ(campaign.runs().at(0).stop, "complete") << "the faults are handed on";
    EXPECT_EQ(fs::exists(folder / "faulty-rough-1" / "run.json"), keep);
    EXPECT_EQ(fs::exists(folder / "faulty-rough-1.log"), keep);
  }
}

TEST(Campaign, DoesNotTakeWhatAnEarlierOneLeftForThisOnes) {
  const fs::path folder = test::TestFolder();
  fs::create_directory(folder / "silent-1");
  test::WriteFile(folder / "silent-1" / "run.json", R"({"stop_reason": "complete",
      "stop_detail": "", "sim_time_s": 1, "contacts": 0, "coverage": {"ratio": 1},
      "control": {"heap_allocations": 0}, "localization": {"error_max_m": 0, "error_max_deg": 0,
      "error_final_m": 0, "error_final_deg": 0}})");
  Campaign campaign(Options({"silent"}), folder, /*keep=*/true);
  RunAll(&campaign);
  EXPECT_EQ(campaign.runs().at(0).stop, "crashed");
}

TEST(Campaign, EndsWithTheFirstMissionWhoseInputIsBad) {
  Campaign campaign(Options({"refused", "complete", "touches"}), test::TestFolder(), false);
  RunAll(&campaign);
  ASSERT_EQ(campaign.runs().size(), 1U);
  EXPECT_EQ(campaign.runs()[0].stop, "refused");
  EXPECT_EQ(campaign.runs()[0].detail, "no such scenario");
  EXPECT_TRUE(campaign.refused());
  EXPECT_EQ(campaign.not_started(), 2U);
}

TEST(Campaign, InterruptedTakesWhatAMissionStillSays) {
  for (const bool says : {true, false}) {
    Campaign campaign(Options({says ? "interrupts" : "interrupts_mute", "complete"}),
                      test::TestFolder(), false);
    RunAll(&campaign);
    ASSERT_EQ(campaign.runs().size(), 1U);
    EXPECT_EQ(campaign.runs()[0].stop, "interrupted");
    EXPECT_EQ(campaign.runs()[0].read, says);
    EXPECT_EQ(campaign.runs()[0].contacts, says ? 1 : 0);
    EXPECT_EQ(campaign.not_started(), 1U);
  }
}

}  // namespace
}  // namespace pipewright::bench
