// SPDX-License-Identifier: MIT
// The command as a person types it: exit codes, and words that help.
#include "tests/support/command.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/post_cell.h"

namespace pipewright::hil {
namespace {

using test::CommandResult;
using test::ReadFile;
using test::RunCommand;
using test::TestFolder;
using test::WriteFile;

namespace fs = std::filesystem;

CommandResult Pipewright(const std::string& arguments, const fs::path& folder) {
  return RunCommand(PIPEWRIGHT_BINARY, arguments, folder);
}

TEST(Command, HelpsAndTellsItsVersion) {
  const fs::path folder = TestFolder();
  const CommandResult version = Pipewright("--version", folder);
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_NE(version.out.find("0.1.0"), std::string::npos) << version.out;
  for (const char* help : {"--help", "inspect --help", "emulate --help", "gateway --help"}) {
    const CommandResult result = Pipewright(help, folder);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.out.find("inspect"), std::string::npos);
    EXPECT_EQ(result.error, "");
  }
  const CommandResult inspect = Pipewright("inspect --help", folder);
  for (const char* option : {"--scenario", "--faults", "--seed", "--planner", "--svfi", "--alpha",
                             "--joint-risk", "--rate", "--realtime", "--bus", "--record-depth",
                             "--out", "--time-limit", "--json", "Exit code"}) {
    EXPECT_NE(inspect.out.find(option), std::string::npos) << option;
  }
}

TEST(Command, SaysWhichFlagIsWrongAndStartsNothing) {
  const struct {
    const char* arguments;
    const char* expected;  ///< in what it says
  } cases[] = {
      {"", "subcommand"},
      {"dance",
       "no command 'dance'; there are: canlog emulate gateway inspect map memory primitives qp "
       "replay "
       "status start stop estop rearm"},
      {"inspect --colour blue", "--colour"},
      {"inspect --seed twelve", "--seed"},
      {"inspect --seed -1", "--seed"},
      {"inspect --planner greedy", "--planner"},
      {"inspect --svfi none", "--svfi"},
      {"inspect --alpha 0.3", "--alpha"},
      {"inspect --alpha 1", "--alpha"},
      {"inspect --alpha nan", "--alpha"},
      {"inspect --rate 5", "--rate"},
      {"inspect --rate 10000", "--rate"},
      {"inspect --time-limit 0", "--time-limit"},
      {"inspect --time-limit nan", "--time-limit"},
      {"inspect --scenario", "--scenario"},
      {"inspect --faults", "--faults"},
      {"inspect --faults rough --bus can0 --no-devices", "--faults"},
      {"replay", "LOG"},
      {"replay run --speed 0", "--speed"},
      {"replay run --speed fast", "--speed"},
      {"replay nowhere", "run.json: cannot be read"},
      {"inspect --bus can0 --camera depth", "--no-devices"},
      {"emulate", "--bus is required"},
      {"emulate --bus nosuchcan9", "--bus nosuchcan9: cannot open the interface"},
      {"emulate --bus can0 --rate 200", "one bus for base and arm"},
      {"emulate --bus can0 --arm-bus can1 --rate 500", "the arm's bus"},
      {"emulate --bus can0 --scenario nosuch", "nosuch"},
      {"emulate --bus can0 --modes scout", "--modes"},
      {"emulate --bus can0 --track 0", "--track"},
      {"emulate --bus can0 --wheel-radius nan", "--wheel-radius"},
      {"emulate --bus can0 --yaw-scale 3", "--yaw-scale"},
      {"emulate --bus can0 --ramp 1", "--ramp"},
      {"emulate --bus can0 --brake 1 -1", "--brake"},
      {"gateway --bus can0", "--controller is required"},
      {"gateway --controller 127.0.0.1", "--bus is required"},
      {"gateway --controller 127.0.0.1 --bus nosuchcan9",
       "--bus nosuchcan9: cannot open the interface"},
      {"gateway --controller 300.0.0.1 --bus can0", "--controller 300.0.0.1"},
      {"gateway --controller 127.0.0.1 --bus can0 --report 30001", "--report"},
      {"gateway --controller 127.0.0.1 --bus can0 --duration 10", "--duration"},
      {"gateway --controller 127.0.0.1 --bus can0 --port 0", "--port"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.arguments);
    const fs::path folder = TestFolder();
    const CommandResult result = Pipewright(c.arguments, folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
    EXPECT_EQ(result.out, "");
    EXPECT_FALSE(fs::exists(folder / "runs"));
  }
}

TEST(Command, SaysWhatIsWrongWithAScenario) {
  const std::string cell = test::kPostCell;
  const struct {
    const char* what;
    std::string text;
    const char* expected;
  } cases[] = {
      {"not TOML", "name = \n", "cell.toml:1"},
      {"empty", "", "name"},
      {"unknown key", cell + "colour = 3\n", "colour"},
      {"wrong type", cell + "[camera]\nrate_hz = \"fast\"\n", "rate_hz"},
      {"out of range", cell + "[camera]\nrate_hz = -3\n", "rate_hz"},
      {"unknown device", cell + "[[fault]]\ndevice = \"arm9\"\nkind = \"absent\"\n", "device"},
      {"start in a box",
       cell + "[[box]]\nname = \"bump\"\ncenter_m = [0.0, 0.0, 0.5]\n"
              "size_m = [0.1, 0.1, 0.1]\n",
       "cell.toml:6:1: start: the robot touches"},
      {"missing mesh", cell + "[[mesh]]\nname = \"m\"\nfile = \"no.stl\"\n", "no.stl"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    const fs::path folder = TestFolder();
    WriteFile(folder / "cell.toml", c.text);
    const CommandResult result = Pipewright("inspect --scenario cell.toml --out run", folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.error.find("pipewright: "), std::string::npos) << result.error;
    EXPECT_NE(result.error.find("cell.toml"), std::string::npos) << result.error;
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
    EXPECT_EQ(result.out, "");
    EXPECT_FALSE(fs::exists(folder / "run"));
  }
}

TEST(Command, SaysThatAScenarioIsNeitherShippedNorAFile) {
  const fs::path folder = TestFolder();
  for (const char* name : {"pipes9", "/nowhere/cell.toml", "."}) {
    const CommandResult result =
        Pipewright(std::string("inspect --scenario ") + name + " --out run", folder);
    EXPECT_EQ(result.exit_code, 2) << name;
    EXPECT_NE(result.error.find(name), std::string::npos) << result.error;
    EXPECT_FALSE(fs::exists(folder / "run"));
  }
}

TEST(Command, SaysWhatIsWrongWithFaults) {
  const struct {
    const char* what;
    const char* text;
    const char* expected;
  } cases[] = {
      {"not TOML", "[camera\n", "dust.toml:1:"},
      {"unknown key", "[camera]\ncolour = 3\n", "dust.toml:2:1: camera.colour: unknown key"},
      {"another table", "[start]\nx_m = 3\n", "dust.toml:1:2: start: unknown key"},
      {"out of range", "[base]\nslip = 2\n", "dust.toml:2:8: base.slip: must be within"},
      {"unknown device", "[[fault]]\ndevice = \"arm9\"\nkind = \"absent\"\n",
       "dust.toml:2:10: fault[0].device: must be"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    const fs::path folder = TestFolder();
    WriteFile(folder / "cell.toml", test::kPostCell);
    WriteFile(folder / "dust.toml", c.text);
    const CommandResult result =
        Pipewright("inspect --scenario cell.toml --faults dust.toml --out run", folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.error.find(std::string("pipewright: ") + c.expected), std::string::npos)
        << result.error;
    EXPECT_EQ(result.out, "");
    EXPECT_FALSE(fs::exists(folder / "run"));
  }
}

TEST(Command, SaysThatFaultsAreNeitherShippedNorAFile) {
  const fs::path folder = TestFolder();
  for (const char* name : {"pipes1", "/nowhere/dust.toml", ".", "''"}) {
    const CommandResult result =
        Pipewright(std::string("inspect --scenario pipes1 --out run --faults ") + name, folder);
    EXPECT_EQ(result.exit_code, 2) << name;
    EXPECT_NE(result.error.find("neither shipped faults"), std::string::npos) << result.error;
    EXPECT_FALSE(fs::exists(folder / "run"));
  }
}

TEST(Command, DoesNotTouchAFolderThatIsNotARuns) {
  const fs::path folder = TestFolder();
  fs::create_directories(folder / "mine");
  WriteFile(folder / "mine" / "can.log", "mine");
  const CommandResult result = Pipewright("inspect --scenario pipes1 --out mine", folder);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.error.find("mine"), std::string::npos) << result.error;
  EXPECT_EQ(ReadFile(folder / "mine" / "can.log"), "mine");
}

TEST(Command, RefusesABusThatIsNotThere) {
  const fs::path folder = TestFolder();
  const CommandResult result =
      Pipewright("inspect --scenario pipes1 --time-limit 1 --bus nosuchcan0 --out run", folder);
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.error.find("nosuchcan0"), std::string::npos) << result.error;
}

TEST(Command, PrintsOneJsonObjectAndNothingElseWhenAsked) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "cell.toml", test::kPostCell);
  const CommandResult result =
      Pipewright("inspect --scenario cell.toml --seed 5 --time-limit 1 --json", folder);
  EXPECT_EQ(result.exit_code, 1);  // not complete
  const auto run = nlohmann::json::parse(result.out, nullptr, /*allow_exceptions=*/false);
  ASSERT_TRUE(run.is_object()) << result.out << result.error;
  EXPECT_EQ(run["stop_reason"], "timeout");
  EXPECT_EQ(run["seed"], 5);
  EXPECT_TRUE(run["faults"].is_null());
  // The default folder names scenario, planner and seed; run.json there is the same object.
  const fs::path evidence = folder / "runs" / "cell-cfnbv-5";
  EXPECT_EQ(nlohmann::json::parse(ReadFile(evidence / "run.json")), run);
  for (const char* name : {"trace.csv", "can.log", "plan.jsonl", "map.bt", "map.ot"}) {
    EXPECT_TRUE(fs::exists(evidence / name)) << name;
  }
}

TEST(Command, LaysFaultsOverAScenarioAndKeepsTheRunApart) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "cell.toml", test::kPostCell);
  WriteFile(folder / "dead.toml", "[[fault]]\ndevice = \"tracer\"\nkind = \"absent\"\n");
  const CommandResult result =
      Pipewright("inspect --scenario cell.toml --faults dead.toml --time-limit 20 --json", folder);
  EXPECT_EQ(result.exit_code, 1);
  const auto run = nlohmann::json::parse(result.out, nullptr, /*allow_exceptions=*/false);
  ASSERT_TRUE(run.is_object()) << result.out << result.error;
  EXPECT_EQ(run["faults"], "dead");
  EXPECT_EQ(run["stop_reason"], "device_fault");
  EXPECT_EQ(nlohmann::json::parse(ReadFile(folder / "runs" / "cell-dead-cfnbv-1" / "run.json")),
            run);
}

TEST(Command, PrintsATableForPeople) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "cell.toml", test::kPostCell);
  const CommandResult result =
      Pipewright("inspect --scenario cell.toml --time-limit 1 --out run", folder);
  EXPECT_EQ(result.exit_code, 1);
  for (const char* expected : {"timeout", "coverage", "contacts", "run"}) {
    EXPECT_NE(result.out.find(expected), std::string::npos) << expected << " in\n" << result.out;
  }
  EXPECT_TRUE(fs::exists(folder / "run" / "report.html"));
}

}  // namespace
}  // namespace pipewright::hil
