// SPDX-License-Identifier: MIT
// What `pipewright replay` says to input that it cannot use. Whole replays are in tests/mission.
#include "hil/cli/replay_command.h"

#include <gtest/gtest.h>

#include "hil/cli/program_record.h"
#include "tests/support/can_logs.h"
#include "tests/support/command.h"

namespace pipewright::hil {
namespace {

namespace fs = std::filesystem;
using test::CommandResult;
using test::WriteFile;
using Json = nlohmann::ordered_json;

class ReplayCommandTest : public testing::Test {
 protected:
  void SetUp() override {
    const ScenarioResult shipped = LoadScenario("pipes1");
    ASSERT_TRUE(shipped.scenario);
    fs::create_directories(run_);
    WriteFile(
        run_ / "run.json",
        Json({{"seed", 1}, {"planner", "cfnbv"}, {"program", ProgramJson(*shipped.scenario, {})}})
            .dump());
    WriteFile(run_ / "can.log", test::CandumpLog({test::DataFrame(0x211, {0, 1}, 1'000'000),
                                                  test::DataFrame(0x211, {0, 1}, 9'000'000)}));
  }

  CommandResult Replay(const std::string& arguments = "run --json --compare") const {
    return test::RunCommand(PIPEWRIGHT_BINARY, "replay " + arguments, folder_);
  }
  void ExpectRefused(const std::string& told) const {
    const CommandResult result = Replay();
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.error.find(told), std::string::npos) << result.error;
    EXPECT_EQ(result.out, "");
  }

  const fs::path folder_ = test::TestFolder();
  const fs::path run_ = folder_ / "run";
};

TEST_F(ReplayCommandTest, NamesTheFileThatIsMissingOrMakesNoSense) {
  WriteFile(run_ / "depth.z16.zst", "no frames at all");
  ExpectRefused("run/depth.z16.zst: is no depth recording");
  fs::remove(run_ / "depth.z16.zst");
  WriteFile(run_ / "can.log", "years of work\nand more\n");
  ExpectRefused("run/can.log: is no log");
  fs::remove(run_ / "can.log");
  ExpectRefused("run/can.log: no such file");
  WriteFile(run_ / "run.json", R"({"seed": 1, "planner": "cfnbv"})");
  ExpectRefused("run/run.json: \"program.workspace.min_m\" is missing");
  WriteFile(run_ / "run.json", R"({"seed": 1, "pla)");
  ExpectRefused("run/run.json: byte 17: is no JSON");
  WriteFile(run_ / "run.json", R"({"seed": 1e999})");
  ExpectRefused("run/run.json: holds a number beyond any");
  fs::remove(run_ / "run.json");
  ExpectRefused("run/run.json: cannot be read");
}

TEST_F(ReplayCommandTest, TakesALogOfDevicesThatNobodyAnswered) {
  const CommandResult result = Replay();
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.error.find("WITHOUT DEPTH"), std::string::npos);
  const Json json = Json::parse(result.out, nullptr, false);
  ASSERT_TRUE(json.is_object());
  EXPECT_EQ(json["log"]["from_devices"], 2);
  EXPECT_EQ(json["log"]["from_robot"], 0);
  EXPECT_NEAR(json["program"]["replayed_s"], 0.009, 1e-9);
}

TEST_F(ReplayCommandTest, TakesTheLogFromStandardInputAndTheRunFromElsewhere) {
  const CommandResult result = Replay("- --run run/run.json --json <run/can.log");
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(Json::parse(result.out, nullptr, false)["log"]["from_devices"], 2);
}

TEST_F(ReplayCommandTest, TellsOfAFrameWhoseTimeCannotBeRight) {
  WriteFile(run_ / "can.log",
            "(0000000000.001000) can0 211#0001\n(0000000000.009000) can0 211#0001\n"
            "(1000000000.010000) can0 211#0001\n(0000000000.011000) can0 211#0001\n");
  const CommandResult result = Replay();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.error.find("1 frames behind a silence"), std::string::npos) << result.error;
  EXPECT_NEAR(Json::parse(result.out, nullptr, false)["program"]["replayed_s"], 0.011, 1e-9);
}

}  // namespace
}  // namespace pipewright::hil
