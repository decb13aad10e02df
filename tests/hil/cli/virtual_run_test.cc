// SPDX-License-Identifier: MIT
#include "hil/cli/virtual_run.h"

#include <gtest/gtest.h>

#include "hil/cli/replay_run.h"
#include "hil/replay/depth_recording.h"
#include "platform/robot/uf7.h"
#include "tests/support/command.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;

TEST(ProgramConfig, TakesEveryOptionToWhereItCounts) {
  const ScenarioResult shipped = LoadScenario("pipes2");
  ASSERT_TRUE(shipped.scenario);
  InspectionOptions options;
  options.seed = 77;
  options.planner = PlannerKind::kCfnbvPaper;
  options.svfi = SvfiMode::kPreviousVelocity;
  options.joint_risk = true;
  options.alpha = 0.9;
  options.rate_hz = 200;
  options.time_limit_s = 12.5;
  const RobotProgramConfig config = ProgramConfig(*shipped.scenario, options);
  EXPECT_EQ(config.mission.planner, PlannerKind::kCfnbvPaper);
  EXPECT_EQ(config.mission.seed, 77U);
  EXPECT_EQ(config.mapping.seed, 77U);
  EXPECT_EQ(config.mission.mission_timeout, std::chrono::milliseconds(12500));
  EXPECT_EQ(config.control.law.constraints.svfi, SvfiMode::kPreviousVelocity);
  EXPECT_TRUE(config.control.law.constraints.joint_risk);
  EXPECT_EQ(config.control.law.constraints.alpha, 0.9);
  EXPECT_EQ(config.control.law.constraints.period_s, 1.0 / 200);
  EXPECT_EQ(config.control.start.x_m, shipped.scenario->start.x_m);
  EXPECT_EQ(config.mapping.start_clearance_m, shipped.scenario->start.clearance_m);
  EXPECT_TRUE(Valid(config.mapping.map));
  EXPECT_TRUE(Valid(config.mission));
  const VoxelRange workspace = VoxelsOf(shipped.scenario->workspace);
  EXPECT_EQ(config.mapping.map.workspace_lo.x, workspace.lo[0]);
  EXPECT_EQ(config.mapping.map.workspace_hi.z, workspace.hi[2]);
}

TEST(ProgramConfig, TellsTheDrivesTheCycleThatTheyWillHave) {
  const ScenarioResult shipped = LoadScenario("pipes1");
  ASSERT_TRUE(shipped.scenario);
  InspectionOptions options;
  options.rate_hz = 200;
  EXPECT_EQ(ProgramConfig(*shipped.scenario, options).control.arm.cycle_ms, 5);
}

TEST(RunVirtual, ComesToRestAndLeavesAWholeFolderWhenInterrupted) {
  ASSERT_EQ(setenv("XDG_CACHE_HOME", (testing::TempDir() + "virtual_run_cache").c_str(), 1), 0);
  const fs::path path = test::TestFolder() / "run";
  const ScenarioResult shipped = LoadScenario("pipes1");
  ASSERT_TRUE(shipped.scenario);
  RunFolder folder;
  ASSERT_EQ(folder.Open(path, {{"stop_reason", "running"}}, /*record_depth=*/true), "");
  int cycles = 0;
  int seconds = 0;
  RunHooks hooks;
  hooks.interrupted = [&cycles] { return ++cycles > 300; };
  hooks.progress = [&seconds](const RunProgress& p) {
    EXPECT_EQ(static_cast<int>(ToSeconds(p.now)), seconds);
    ++seconds;
  };
  const nlohmann::ordered_json run = RunVirtual(*shipped.scenario, {}, folder, hooks);
  EXPECT_EQ(folder.Close(), "");
  EXPECT_GE(run["sim_time_s"], 3.0);
  EXPECT_LE(run["sim_time_s"], 9.0);
  EXPECT_GE(seconds, 3);
  EXPECT_NE(run["stop_reason"], "complete");
  EXPECT_FALSE(Passed(run));
  EXPECT_TRUE(fs::exists(path / "map.bt"));
  EXPECT_GT(fs::file_size(path / "can.log"), 100'000U);
  EXPECT_GE(run["control"]["cycles"], 300);
  EXPECT_EQ(run["control"]["heap_allocations"], 0);

  // And somebody's word, too, is replayed at its instant.
  const RecordedProgramResult recorded = ReadProgram(run);
  ASSERT_TRUE(recorded.program) << recorded.error;
  RecordedBus bus(path / "can.log");
  DepthReader depth;
  ASSERT_EQ(bus.Open(), "");
  ASSERT_EQ(depth.Open(path / kDepthFileName), "");
  const nlohmann::ordered_json replay =
      RunReplay({.program = *recorded.program, .bus = bus, .depth = &depth});
  EXPECT_EQ(bus.comparison().differences(), 0U);
  EXPECT_EQ(bus.comparison().same(), run["can"]["tx"].get<std::uint64_t>());
  EXPECT_NEAR(replay["replayed_s"], run["sim_time_s"], 0.02);
}

}  // namespace
}  // namespace pipewright::hil
