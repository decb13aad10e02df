// SPDX-License-Identifier: MIT
#include "hil/canlog/log_set.h"

#include "tests/hil/canlog/read_log.h"

namespace pipewright::hil {
namespace {

using namespace test;

std::vector<LogFrame> All(LogSet& set) {
  std::vector<LogFrame> all;
  for (auto frames = set.Next(); !frames.empty(); frames = set.Next()) {
    all.insert(all.end(), frames.begin(), frames.end());
  }
  return all;
}

TEST(LogSet, ReadsFilesAfterEachOtherWhateverTheirFormats) {
  const std::filesystem::path folder = TestFolder();
  const std::vector<LogFrame> frames = RandomFrames(1000, 5);
  const std::vector<LogFrame> first(frames.begin(), frames.begin() + 400);
  const std::vector<LogFrame> second(frames.begin() + 400, frames.end());
  WriteFile(folder / "1", Gz(CandumpLog(first)));
  WriteFile(folder / "2", "");
  WriteFile(folder / "3", Pcapng(second, true, true));
  LogSet set({folder / "1", folder / "2", folder / "3"}, {}, {});
  std::uint64_t shown = 0;
  std::uint64_t in_all = 0;
  set.set_progress([&](std::uint64_t bytes, std::uint64_t all) {
    EXPECT_GE(bytes, shown);
    shown = bytes;
    in_all = all;
  });
  ExpectFrames(All(set), frames, frames.size());
  EXPECT_EQ(set.error(), "");
  EXPECT_TRUE(set.whole());
  ASSERT_EQ(set.files().size(), 3U);
  EXPECT_EQ(set.files()[0].format, "candump -L");
  EXPECT_EQ(set.files()[0].packing, "gz");
  EXPECT_EQ(set.files()[0].bytes, CandumpLog(first).size());
  EXPECT_EQ(set.files()[0].frames, 400U);
  EXPECT_EQ(set.files()[2].frames, 600U);
  EXPECT_EQ(set.channels().size(), 1);  // both call it can0
  EXPECT_EQ(shown, in_all);
}

TEST(LogSet, StopsAtAFileThatCannotBeRead) {
  const std::filesystem::path folder = TestFolder();
  WriteFile(folder / "1", CandumpLog(OneOfEach()));
  LogSet set({folder / "1", folder / "none", folder / "1"}, {}, {});
  EXPECT_EQ(All(set).size(), OneOfEach().size());
  EXPECT_NE(set.error().find("none: no such file"), std::string::npos);
}

TEST(LogSet, GivesWhatTheFilterWantsAndCountsAll) {
  const std::filesystem::path folder = TestFolder();
  WriteFile(folder / "1", CandumpLog(RandomFrames(3000, 6)) + "cut");
  FrameFilter filter;
  ASSERT_EQ(filter.AddIds("10B"), "");
  LogSet set({folder / "1"}, {}, filter);
  for (const LogFrame& frame : All(set)) {
    EXPECT_EQ(frame.id, 0x10BU);
  }
  EXPECT_EQ(set.files()[0].frames, 3000U);
  EXPECT_FALSE(set.whole());
  EXPECT_EQ(set.files()[0].problems.end(), "ends within line 3001");
}

}  // namespace
}  // namespace pipewright::hil
