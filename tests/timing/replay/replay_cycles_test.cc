// SPDX-License-Identifier: MIT
// The two programs as a person types them: bench_control --record, then replay_cycles.
#include <gtest/gtest.h>

#include "tests/support/command.h"

namespace pipewright::timing {
namespace {

using test::CommandResult;
using test::TestFolder;
using test::WriteFile;

namespace fs = std::filesystem;

CommandResult Record(const std::string& arguments, const fs::path& folder) {
  return test::RunCommand(PIPEWRIGHT_BENCH_CONTROL, arguments, folder);
}

CommandResult Replay(const std::string& arguments, const fs::path& folder) {
  return test::RunCommand(PIPEWRIGHT_REPLAY_CYCLES, arguments, folder);
}

bool Holds(const CommandResult& result, const std::string& what) {
  return result.out.find(what) != std::string::npos;
}

TEST(ReplayCycles, ReplaysWhatBenchControlRecorded) {
  const fs::path folder = TestFolder();
  const CommandResult recorded = Record("--record run.rec --cycles 30 --rate 200", folder);
  ASSERT_EQ(recorded.exit_code, 0) << recorded.error;
  const CommandResult replayed = Replay("run.rec --sent sent.log", folder);
  EXPECT_EQ(replayed.exit_code, 0) << replayed.error;
  EXPECT_EQ(replayed.error, "");
  EXPECT_TRUE(Holds(replayed, "counted           30\n")) << replayed.out;
  EXPECT_TRUE(Holds(replayed, "frames_different  0\n")) << replayed.out;
  EXPECT_EQ(test::ReadFile(folder / "sent.log").substr(0, 25), "(0000000000.000000) can1 ");
}

TEST(ReplayCycles, SaysWhatItIsNotGiven) {
  const fs::path folder = TestFolder();
  for (const char* arguments :
       {"", "--lsb 1", "run.rec --lsb", "run.rec --lsb -1", "run.rec --lsb 1x", "run.rec other.rec",
        "--fast run.rec", "run.rec --sent"}) {
    const CommandResult result = Replay(arguments, folder);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_EQ(result.error, "usage: replay_cycles RECORDING [--lsb N] [--sent FILE]\n");
  }
}

TEST(ReplayCycles, SaysWhatIsWrongWithAFileAndWhere) {
  const fs::path folder = TestFolder();
  WriteFile(folder / "text.rec", "no recording at all");
  WriteFile(folder / "cut.rec", std::string("PWCYCLES\1\0", 10));
  const auto error_of = [&folder](const std::string& arguments) {
    const CommandResult result = Replay(arguments, folder);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    return result.error;
  };
  EXPECT_EQ(error_of("none.rec"), "replay_cycles: none.rec: No such file or directory\n");
  EXPECT_EQ(error_of("text.rec"),
            "replay_cycles: text.rec: it is no recording of control cycles, at byte 8\n");
  EXPECT_EQ(error_of("cut.rec"), "replay_cycles: cut.rec: it ends early, at byte 10\n");
  EXPECT_EQ(error_of("text.rec --sent no/folder"),
            "replay_cycles: no/folder: No such file or directory\n");
}

TEST(BenchControl, SaysWhereItCannotRecord) {
  const CommandResult result = Record("--record no/folder --cycles 1", TestFolder());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.error, "bench_control: no/folder: No such file or directory\n");
}

}  // namespace
}  // namespace pipewright::timing
