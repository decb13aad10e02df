// SPDX-License-Identifier: MIT
#include "hil/canlog/load_windows.h"

#include <gtest/gtest.h>

#include <map>

#include "platform/can/bits.h"
#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

using namespace test;

std::vector<WindowLoad> Windows(std::vector<LogFrame> frames, std::int64_t window_ns) {
  std::vector<WindowLoad> all;
  LoadWindows windows(window_ns, [&all](const WindowLoad& window) { all.push_back(window); });
  windows.Add(frames);
  windows.End();
  return all;
}

TEST(LoadWindows, AreThoseOfBruteForce) {
  std::vector<LogFrame> frames = RandomFrames(5000, 12);
  Rng rng(12);
  constexpr std::int64_t kWindow = 20'000'000;
  std::map<std::pair<std::int64_t, int>, WindowLoad> expected;
  for (LogFrame& f : frames) {
    f.channel = static_cast<std::uint8_t>(rng.Index(2));
    const std::int64_t window = (f.stamp_ns - frames[0].stamp_ns) / kWindow;
    WindowLoad& load = expected[{window, f.channel}];
    load.begin_ns = frames[0].stamp_ns + window * kWindow;
    ++load.frames;
    load.bits += static_cast<std::uint64_t>(can::FrameBits(ClassicFrame(f)));
  }
  const std::vector<WindowLoad> got = Windows(frames, kWindow);
  ASSERT_EQ(got.size(), expected.size());
  std::size_t i = 0;
  for (const auto& [key, load] : expected) {
    EXPECT_EQ(got[i].begin_ns, load.begin_ns);
    EXPECT_EQ(int{got[i].channel}, key.second);
    EXPECT_EQ(got[i].frames, load.frames);
    EXPECT_EQ(got[i].bits, load.bits);
    ++i;
  }
}

TEST(LoadWindows, PassOverSilenceAndKeepWhatComesLate) {
  const std::vector<WindowLoad> got =
      Windows({DataFrame(1, {}, 0), DataFrame(1, {}, 9'000'000'000'000'000'000),
               DataFrame(1, {}, 5), DataFrame(1, {}, 9'000'000'000'000'000'001)},
              1000);
  ASSERT_EQ(got.size(), 2U);
  EXPECT_EQ(got[0].frames, 1U);
  EXPECT_EQ(got[1].begin_ns, 9'000'000'000'000'000'000);
  EXPECT_EQ(got[1].frames, 3U);
}

TEST(LoadWindows, LeaveOutErrorMessagesFramesWithoutTimeAndBitsOfFd) {
  std::vector<LogFrame> frames(3, DataFrame(1, {}, 0));
  frames[0].error = true;
  frames[1].stamped = false;
  frames[2].fd = true;
  LoadWindows windows(1000, [](const WindowLoad& window) {
    EXPECT_EQ(window.frames, 1U);
    EXPECT_EQ(window.bits, 0U);
  });
  windows.Add(frames);
  windows.End();
  EXPECT_EQ(windows.left_out(), 1U);
}

}  // namespace
}  // namespace pipewright::hil
