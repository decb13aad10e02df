// SPDX-License-Identifier: MIT
#include "hil/cli/bus_choice.h"

#include <gtest/gtest.h>

namespace pipewright::hil {
namespace {

using Names = std::vector<std::string>;

TEST(BusChoice, ReadsWhatAPersonWrites) {
  const struct {
    const char* text;
    bool shared;
    Names interfaces;
  } cases[] = {
      {"loopback", false, {}},       {"loopback-shared", true, {}},
      {"can0", true, {"can0"}},      {"can0,vcan1", false, {"can0", "vcan1"}},
      {"can0,can0", true, {"can0"}},
  };
  for (const auto& c : cases) {
    std::string error;
    const BusChoice choice = ParseBus(c.text, &error);
    EXPECT_EQ(error, "") << c.text;
    EXPECT_EQ(choice.shared, c.shared) << c.text;
    EXPECT_EQ(choice.interfaces, c.interfaces) << c.text;
    EXPECT_EQ(choice.is_virtual(), c.interfaces.empty()) << c.text;
  }
}

TEST(BusChoice, RefusesWhatNamesNoBus) {
  for (const char* text : {"", ",", "can0,", ",can0", "a,b,c", "loopback,can0", "can0,loopback"}) {
    std::string error;
    ParseBus(text, &error);
    EXPECT_NE(error.find(std::string("--bus ") + text), std::string::npos) << text;
  }
}

TEST(BusChoice, EveryWholePeriodHasABusCycleThatTheBusCarries) {
  for (int period_ms = 1; period_ms <= 20; ++period_ms) {
    for (const bool shared : {false, true}) {
      const double rate_hz = 1000.0 / period_ms;
      const bool fits = !shared || period_ms >= 8;
      EXPECT_EQ(RateError(rate_hz, shared).empty(), fits) << rate_hz << " " << shared;
      if (fits) {
        const int cycle_ms = ArmCycle_ms(rate_hz, shared);
        EXPECT_EQ(cycle_ms % period_ms, 0);
        EXPECT_GE(cycle_ms, shared ? 8 : 4);
        EXPECT_LE(cycle_ms, 20);
      }
    }
  }
  EXPECT_EQ(ArmCycle_ms(1000, false), 4);
  EXPECT_EQ(ArmCycle_ms(500, false), 4);
  EXPECT_EQ(ArmCycle_ms(1000.0 / 3, false), 6);
  EXPECT_EQ(ArmCycle_ms(200, false), 5);
  EXPECT_EQ(ArmCycle_ms(100, true), 10);
}

TEST(BusChoice, SaysWhyARateIsRefused) {
  for (const double rate_hz : {0.0, 49.0, 60.0, 300.0, 999.0, 2000.0, -100.0}) {
    EXPECT_NE(RateError(rate_hz, false).find("whole milliseconds"), std::string::npos) << rate_hz;
  }
  EXPECT_NE(RateError(200, true).find("at most 125 Hz"), std::string::npos);
}

}  // namespace
}  // namespace pipewright::hil
