// SPDX-License-Identifier: MIT
#include "hil/canlog/frame_filter.h"

#include <gtest/gtest.h>

#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

using namespace test;

LogFrame WithId(std::uint32_t id, bool extended = false, bool error = false) {
  LogFrame frame = DataFrame(id, {});
  frame.extended = extended;
  frame.error = error;
  return frame;
}

bool Wants(const std::string& ids, LogFrame frame) {
  FrameFilter filter;
  EXPECT_EQ(filter.AddIds(ids), "");
  return filter.Keep({&frame, 1}) == 1;
}

TEST(FrameFilter, TakesIdsRangesMasksAndErrors) {
  const struct {
    const char* ids;
    std::uint32_t id;
    bool extended, error, wanted;
  } cases[] = {
      {"211", 0x211, false, false, true},
      {"211", 0x212, false, false, false},
      {"211", 0x211, true, false, false},
      {"00000211", 0x211, true, false, true},
      {"00000211", 0x211, false, false, false},
      {"180-1ff", 0x180, false, false, true},
      {"180-1ff", 0x1FF, false, false, true},
      {"180-1ff", 0x200, false, false, false},
      {"180/780", 0x187, false, false, true},
      {"180/780", 0x207, false, false, false},
      {"0/0", 0x123, false, false, true},
      {"187/780", 0x181, false, false, true},  // bits of the id where the mask has none are ignored
      {"18EB0000/1FFF0000", 0x18EBFF00, true, false, true},
      {"0000-1FFFFFFF", 0x18EBFF00, true, false, true},
      {"100,200,error", 0x200, false, false, true},
      {"100,200,error", 0x80, false, true, true},
      {"080", 0x80, false, true, false},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(testing::Message() << c.ids << " of " << std::hex << c.id);
    EXPECT_EQ(Wants(c.ids, WithId(c.id, c.extended, c.error)), c.wanted);
  }
}

TEST(FrameFilter, SaysWhatIsWrongWithAnId) {
  for (const char* ids : {"", "xyz", "100,", "800", "200-100", "100-", "100/", "20000000",
                          "100-1FFFFFFFFF", "100 ", "0x111"}) {
    SCOPED_TRACE(ids);
    FrameFilter filter;
    EXPECT_NE(filter.AddIds(ids).find("is neither a hex id"), std::string::npos);
  }
}

TEST(FrameFilter, TakesTimesFromTheFirstFrameOrOfTheLogsClock) {
  std::vector<LogFrame> log;
  for (int i = 0; i < 10; ++i) {
    log.push_back(DataFrame(0x100, {i}, 1'700'000'000'000'000'001 + 500'000'000LL * i));
  }
  const struct {
    const char* from;
    const char* to;
    std::vector<int> kept;
  } cases[] = {
      {"0", "0", {0}},
      {"1", "2", {2, 3, 4}},
      {"1.000000001", "", {3, 4, 5, 6, 7, 8, 9}},
      {"", "0.5", {0, 1}},
      {"@1700000004", "", {8, 9}},
      {"@1700000003.5", "@1700000004.5", {7, 8}},
      {"-3", "", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}},
      {"100", "", {}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(testing::Message() << c.from << " to " << c.to);
    FrameFilter filter;
    EXPECT_EQ(*c.from == '\0' ? "" : filter.SetFrom(c.from), "");
    EXPECT_EQ(*c.to == '\0' ? "" : filter.SetTo(c.to), "");
    // In two blocks: the first frame of the log is that of the first block.
    std::vector<LogFrame> frames = log;
    std::vector<int> kept;
    for (const std::span<LogFrame> block :
         {std::span(frames).first(3), std::span(frames).subspan(3)}) {
      for (const LogFrame& frame : block.first(filter.Keep(block))) {
        kept.push_back(frame.data[0]);
      }
    }
    EXPECT_EQ(kept, c.kept);
  }
}

TEST(FrameFilter, KeepsNoFrameWithoutATimeWhenTimesAreAskedFor) {
  LogFrame frame = DataFrame(0x100, {});
  frame.stamped = false;
  FrameFilter filter;
  EXPECT_TRUE(filter.keeps_all());
  EXPECT_EQ(filter.Keep({&frame, 1}), 1U);
  EXPECT_EQ(filter.SetFrom("0"), "");
  EXPECT_EQ(filter.Keep({&frame, 1}), 0U);
}

TEST(FrameFilter, SaysWhatIsWrongWithATime) {
  for (const char* time : {"soon", "@", "1s", "nan", "inf", "1e10"}) {
    FrameFilter filter;
    EXPECT_NE(filter.SetTo(time).find(std::string("--to ") + time + ": is neither seconds"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace pipewright::hil
