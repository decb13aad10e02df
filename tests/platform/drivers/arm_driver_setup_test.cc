// SPDX-License-Identifier: MIT
// From silence to seven drives enabled.
#include <gtest/gtest.h>

#include <cstdint>

#include "platform/drivers/arm_driver.h"
#include "tests/platform/drivers/arm_driver_fixture.h"
#include "tests/platform/drivers/fake_devices.h"

namespace pipewright {
namespace {

using test::ArmDriverTest;

TEST_F(ArmDriverTest, ConfiguresStartsAndEnablesAllSeven) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100)) << Name(driver_.fault().problem);
  for (test::FakeDrive& d : drives_) {
    const std::uint32_t n = static_cast<std::uint32_t>(d.node);
    EXPECT_EQ(d.written[0x140001], 0x200 + n);
    EXPECT_EQ(d.written[0x140002], 1U);
    EXPECT_EQ(d.written[0x140005], 100U);
    EXPECT_EQ(d.written[0x160000], 2U);
    EXPECT_EQ(d.written[0x160001], 0x60400010U);
    EXPECT_EQ(d.written[0x160002], 0x60FF0020U);
    EXPECT_EQ(d.written[0x180001], 0x180 + n);
    EXPECT_EQ(d.written[0x1A0001], 0x60640020U);
    EXPECT_EQ(d.written[0x1A0002], 0x606C0020U);
    EXPECT_EQ(d.written[0x180101], 0x280 + n);
    EXPECT_EQ(d.written[0x180102], 255U);
    EXPECT_EQ(d.written[0x1A0101], 0x60410010U);
    EXPECT_EQ(d.written[0x1A0102], 0x60610008U);
    EXPECT_EQ(d.written[0x101700], 100U);
    EXPECT_EQ(d.written[0x101601], 0x007F012CU);
    EXPECT_EQ(d.written[0x606000], 9U);
    EXPECT_EQ(d.written[0x60C201], 10U);
    EXPECT_EQ(d.written[0x60C202], 0xFDU);
    EXPECT_EQ(d.status, 0x1237);
  }
  EXPECT_EQ(driver_.tx_dropped(), 0);
}

TEST_F(ArmDriverTest, AFaultLeftFromBeforeIsResetOnceByARisingEdge) {
  drives_[3].status = 0x0218;
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 200));
  EXPECT_EQ(drives_[3].resets, 1);
}

TEST_F(ArmDriverTest, ADriveThatRestartsDuringSetUpIsSetUpAgain) {
  ASSERT_TRUE(RunUntil(DriverPhase::kConfiguring, 20));
  Cycles(10);
  drives_[2].written.clear();
  drives_[2].Say(test::Bytes(0x703, {0x00}));
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 200));
  EXPECT_EQ(drives_[2].written[0x140001], 0x203U);
}

struct SetupCase {
  const char* name;
  void (*cause)(test::FakeDrive& drive);
  Problem problem;
  Status status;
  std::uint32_t detail;
};

TEST_F(ArmDriverTest, EachWayThatSetUpCanFailNamesTheDrive) {
  const SetupCase kCases[] = {
      {"absent", [](test::FakeDrive& d) { d.silent = true; }, Problem::kNotHeard, Status::kTimeout,
       0},
      {"mute", [](test::FakeDrive& d) { d.mute_index = 0x1600; }, Problem::kSetupUnanswered,
       Status::kTimeout, 0x1600},
      {"refuses", [](test::FakeDrive& d) { d.abort_index = 0x60C2; }, Problem::kSetupRefused,
       Status::kFault, 0x06020000},
      {"other units", [](test::FakeDrive& d) { d.unit = 0x00410000; }, Problem::kWrongDevice,
       Status::kFault, 0x60A8},
      {"never enabled", [](test::FakeDrive& d) { d.refuses_enable = true; }, Problem::kNotEnabled,
       Status::kTimeout, 0x0233},
  };
  for (const SetupCase& c : kCases) {
    SCOPED_TRACE(c.name);
    Renew();
    driver_.Reset();
    c.cause(drives_[4]);
    ASSERT_TRUE(RunUntil(DriverPhase::kFault, 600));
    EXPECT_EQ(driver_.fault().problem, c.problem);
    EXPECT_EQ(driver_.fault().status, c.status);
    EXPECT_EQ(driver_.fault().node, 5);
    EXPECT_EQ(driver_.fault().detail, c.detail);
  }
}

}  // namespace
}  // namespace pipewright
