// SPDX-License-Identifier: MIT
#include "hil/cli/bus_load.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "platform/can/bits.h"
#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

/// Longest frame of n payload bytes, by ISO 11898-1's rule for stuff bits.
TEST(WorstFrameBits, AreThoseOfTheTextbookAndNoFrameHasMore) {
  constexpr int kTextbook[][2] = {{0, 55}, {1, 65}, {2, 75}, {3, 85}, {6, 115}, {8, 135}};
  for (const auto& [bytes, bits] : kTextbook) {
    EXPECT_EQ(WorstFrameBits(bytes), bits) << bytes;
  }
  Rng rng(1);
  for (int i = 0; i < 20'000; ++i) {
    can::Frame frame{.id = static_cast<std::uint32_t>(rng.Index(0x800)),
                     .dlc = static_cast<std::uint8_t>(rng.Index(9))};
    for (std::uint8_t& byte : frame.data) {
      byte = i % 2 == 0 ? static_cast<std::uint8_t>(rng.Next()) : 0xF8;
    }
    ASSERT_LE(can::FrameBits(frame), WorstFrameBits(frame.dlc));
  }
}

// Worked by hand. Of the base eight frames at 50 Hz, one at 40, two at 10, one at 2, 8 bytes each;
// a cycle of the arm is 55 + 7 * 115 + 7 * 135 bits, status 7 * 4 * 85, heartbeats 8 * 10 * 65 a
// second.
TEST(BusLoad, IsWhatThePaperSays) {
  EXPECT_NEAR(BaseLoad(500'000), (8 * 50 + 40 + 2 * 10 + 2) * 135.0 / 500'000, 1e-9);
  EXPECT_NEAR(ArmLoad(100, 500'000), 0.376, 5e-4);
  EXPECT_NEAR(ArmLoad(100, 1'000'000), 0.188, 5e-4);
  EXPECT_NEAR(ArmLoad(250, 500'000), 0.918, 5e-3);
  EXPECT_NEAR(ArmLoad(250, 1'000'000), 0.459, 3e-3);
}

TEST(LoadError, RefusesWhatCannotFit) {
  EXPECT_EQ(LoadError(100, true), "");
  EXPECT_EQ(LoadError(125, true), "");
  EXPECT_EQ(LoadError(250, false), "");
  EXPECT_NE(LoadError(200, true).find("one bus for base and arm at 500 kbit/s"), std::string::npos);
  EXPECT_NE(LoadError(500, false).find("the arm's bus at 1000 kbit/s"), std::string::npos);
}

}  // namespace
}  // namespace pipewright::hil
