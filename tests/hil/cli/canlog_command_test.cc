// SPDX-License-Identifier: MIT
// `pipewright canlog` as a person types it. That logs are read right is tested in tests/hil/canlog.
#include <gtest/gtest.h>

#include "tests/support/can_logs.h"
#include "tests/support/command_json.h"

namespace pipewright::hil {
namespace {

using nlohmann::json;
using namespace test;

namespace fs = std::filesystem;

const std::string kStartup = std::string(PIPEWRIGHT_TEST_DATA) + "/can/canopen_csv_startup.log";

CommandResult Canlog(const std::string& arguments, const fs::path& folder) {
  return RunCommand(PIPEWRIGHT_BINARY, "canlog " + arguments, folder);
}

TEST(CanlogCommand, TeachesByHelp) {
  const CommandResult help = Canlog("--help", TestFolder());
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.error, "");
  for (const char* expected : {"FILE", "--id", "--from", "--to", "--deltas", "--bitrate", "--json",
                               "stats", "Exit code", "Example"}) {
    EXPECT_NE(help.out.find(expected), std::string::npos) << expected;
  }
}

TEST(CanlogCommand, GivesTheStatisticsOfALogThatAnotherLibraryMade) {
  // Counted by hand with grep and awk.
  const json run = Parsed(Canlog("'" + kStartup + "' --bitrate 1000000 --json", TestFolder()));
  EXPECT_EQ(run["files"][0]["format"], "candump -L");
  EXPECT_EQ(run["files"][0]["frames"], 147);
  EXPECT_EQ(run["files"][0]["bytes"], 5899);
  EXPECT_EQ(run["all"]["frames"], 147);
  EXPECT_EQ(run["channels"][0]["channel"], "vcan1");
  ASSERT_EQ(run["ids"].size(), 7U);
  const json& sync = run["ids"][1];
  EXPECT_EQ(sync["id"], "080");
  EXPECT_EQ(sync["name"], "sync");
  EXPECT_EQ(sync["frames"], 34);
  EXPECT_EQ(run["ids"][6]["name"], "heartbeat 1");
  EXPECT_NEAR(run["ids"][6]["rate_hz"].get<double>(), 24 / 2.351604, 1e-6);
  EXPECT_GT(run["all"]["bits"], 147 * 47);
  EXPECT_EQ(run["frames_beyond_ids"], 0);
}

TEST(CanlogCommand, TakesTheWordBeforeOrBehindTheFileAndReadsStandardInput) {
  const fs::path folder = TestFolder();
  const std::string file = "'" + kStartup + "'";
  const CommandResult plain = Canlog(file, folder);
  EXPECT_EQ(plain.exit_code, 0);
  EXPECT_NE(plain.out.find("rpdo1_joint_command 1"), std::string::npos);
  EXPECT_EQ(Canlog(file + " stats", folder).out, plain.out);
  EXPECT_EQ(Canlog("stats " + file, folder).out, plain.out);
  const json run = Parsed(Canlog("- --json <" + file, folder));
  EXPECT_EQ(run["all"]["frames"], 147);
  EXPECT_EQ(run["files"][0]["path"], "-");
}

TEST(CanlogCommand, ChoosesFramesByIdAndTime) {
  const fs::path folder = TestFolder();
  const std::string file = "'" + kStartup + "' --json ";
  EXPECT_EQ(Parsed(Canlog(file + "--id 580/780,601", folder))["all"]["frames"], 64);
  EXPECT_EQ(Parsed(Canlog(file + "--id 701 --to 0.1", folder))["all"]["frames"], 2);
  EXPECT_EQ(Parsed(Canlog(file + "--id 701 --from @1795305883.5", folder))["all"]["frames"], 4);
}

TEST(CanlogCommand, TellsOfWhatItCouldNotReadAndExitsWithOne) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "bad.log", "(1.0) can0 123#11\n(2.0) can0 123#1\n(3.0) can0 1");
  const CommandResult result = Canlog("bad.log --json", folder);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.error.find("bad.log: line 2: expected at most 8 bytes in pairs of hex digits"),
            std::string::npos);
  EXPECT_NE(result.error.find("bad.log: ends within line 3"), std::string::npos);
  const json run = json::parse(result.out);
  EXPECT_EQ(run["files"][0]["malformed"], 1);
  EXPECT_EQ(run["files"][0]["ends_early"], "ends within line 3");
  EXPECT_EQ(run["all"]["frames"], 1);
}

TEST(CanlogCommand, RefusesBadInputWithTwo) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "list.txt", "milk\nbread\n");
  const struct {
    const char* arguments;
    const char* expected;
  } cases[] = {
      {"", "FILE"},
      {"none.log", "none.log: no such file"},
      {"list.txt", "list.txt: is no log that is known here"},
      {"list.txt --id 9999999999", "--id 9999999999: is neither"},
      {"list.txt --from soon", "--from soon: is neither"},
      {"list.txt --bitrate 7", "--bitrate"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.arguments);
    const CommandResult result = Canlog(c.arguments, folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.error.find(c.expected), std::string::npos) << result.error;
  }
}

}  // namespace
}  // namespace pipewright::hil
