// SPDX-License-Identifier: MIT
#include "hil/devices/csv_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

constexpr double kDt_s = 0.001;

CsvDrive Ready() {
  CsvDrive drive;
  drive.PowerUp();
  return drive;
}

CsvDrive Enabled() {
  CsvDrive drive = Ready();
  for (const int word : {0x06, 0x07, 0x0F}) {
    drive.Command(static_cast<std::uint16_t>(word));
  }
  EXPECT_EQ(drive.state(), DriveState::kOperationEnabled);
  return drive;
}

void Turn(CsvDrive& drive, int steps, double target, double& position, const DriveLimits& limits) {
  for (int i = 0; i < steps; ++i) {
    drive.Step(kDt_s, target, true, position, limits);
    position += drive.velocity_radps() * kDt_s;
  }
}

// Values of a recorded start-up, of a maxon EPOS (0x07 low nibble with bit 5) and of CiA 402-2's
// table of statusword patterns.
TEST(CsvDrive, StatuswordsAreThoseOfRealDrives) {
  CsvDrive drive;
  EXPECT_EQ(drive.Statusword(true) & 0x4F, 0x00);
  drive.PowerUp();
  EXPECT_EQ(drive.Statusword(true), 0x0250);
  drive.Command(0x06);
  EXPECT_EQ(drive.Statusword(true), 0x0231);
  drive.Command(0x07);
  EXPECT_EQ(drive.Statusword(true), 0x0233);
  drive.Command(0x0F);
  EXPECT_EQ(drive.Statusword(true), 0x1237);
  EXPECT_EQ(drive.Statusword(false), 0x0237);
  drive.Command(0x02);
  EXPECT_EQ(drive.Statusword(true) & 0x6F, 0x07);
  drive.RaiseFault();
  EXPECT_EQ(drive.Statusword(true) & 0x4F, 0x0F);
  drive.Step(kDt_s, 0, true, 0, {});
  EXPECT_EQ(drive.Statusword(true) & 0x4F, 0x08);
}

TEST(CsvDrive, EachControlwordCausesTheTransitionOfTheStandard) {
  using S = DriveState;
  struct Case {
    const char* name;
    std::initializer_list<std::uint16_t> words;
    S state;
  };
  const Case cases[] = {
      {"switch on alone does nothing", {0x07}, S::kSwitchOnDisabled},
      {"enable alone does nothing", {0x0F}, S::kSwitchOnDisabled},
      {"2 shutdown", {0x06}, S::kReadyToSwitchOn},
      {"3 switch on", {0x06, 0x07}, S::kSwitchedOn},
      {"3 and 4 at once", {0x06, 0x0F}, S::kOperationEnabled},
      {"4 enable", {0x06, 0x07, 0x0F}, S::kOperationEnabled},
      {"5 disable operation", {0x06, 0x07, 0x0F, 0x07}, S::kSwitchedOn},
      {"6 shutdown", {0x06, 0x07, 0x06}, S::kReadyToSwitchOn},
      {"7 disable voltage", {0x06, 0x00}, S::kSwitchOnDisabled},
      {"7 quick stop", {0x06, 0x02}, S::kSwitchOnDisabled},
      {"8 shutdown", {0x06, 0x07, 0x0F, 0x06}, S::kReadyToSwitchOn},
      {"9 disable voltage", {0x06, 0x07, 0x0F, 0x00}, S::kSwitchOnDisabled},
      {"10 disable voltage", {0x06, 0x07, 0x00}, S::kSwitchOnDisabled},
      {"11 quick stop", {0x06, 0x07, 0x0F, 0x02}, S::kQuickStopActive},
      {"11, and no way back with option 2", {0x06, 0x07, 0x0F, 0x02, 0x0F}, S::kQuickStopActive},
      {"12 disable voltage", {0x06, 0x07, 0x0F, 0x02, 0x00}, S::kSwitchOnDisabled},
      {"a reset without a fault does nothing", {0x06, 0x80}, S::kReadyToSwitchOn},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    CsvDrive drive = Ready();
    for (const std::uint16_t word : c.words) {
      drive.Command(static_cast<std::uint16_t>(word));
    }
    EXPECT_EQ(drive.state(), c.state);
  }
}

TEST(CsvDrive, AFaultNeedsARisingResetBitAndItsCauseGone) {
  CsvDrive drive = Enabled();
  drive.Command(0x8F);  // bit 7 already high before the fault
  drive.RaiseFault();
  drive.Step(kDt_s, 0, true, 0, {});
  ASSERT_EQ(drive.state(), DriveState::kFault);
  drive.Command(0x80);
  EXPECT_EQ(drive.state(), DriveState::kFault);
  drive.Command(0x00);
  drive.HoldFault(true);
  drive.Command(0x80);
  EXPECT_EQ(drive.state(), DriveState::kFault);
  drive.HoldFault(false);
  drive.Command(0x00);
  drive.Command(0x80);
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);
}

TEST(CsvDrive, TheVelocityRampsAtTheAccelerationLimit) {
  CsvDrive drive = Enabled();
  double position = 0;
  const DriveLimits limits{.accel_radps2 = 4.0};
  Turn(drive, 100, 1.0, position, limits);
  EXPECT_NEAR(drive.velocity_radps(), 0.4, 1e-12);
  Turn(drive, 200, 1.0, position, limits);
  EXPECT_EQ(drive.velocity_radps(), 1.0);
  Turn(drive, 1, -9.0, position, limits);
  EXPECT_NEAR(drive.velocity_radps(), 0.996, 1e-12);
}

TEST(CsvDrive, QuickStopRampsDownThenDisablesOrStays) {
  for (const QuickStopOption option :
       {QuickStopOption::kRampThenDisable, QuickStopOption::kRampThenStay}) {
    CsvDrive drive = Enabled();
    drive.set_quick_stop_option(option);
    double position = 0;
    const DriveLimits limits{.quick_stop_radps2 = 10.0};
    Turn(drive, 500, 1.0, position, limits);
    drive.Command(0x02);
    Turn(drive, 50, 1.0, position, limits);
    EXPECT_NEAR(drive.velocity_radps(), 0.5, 1e-12);
    EXPECT_EQ(drive.state(), DriveState::kQuickStopActive);
    Turn(drive, 60, 1.0, position, limits);
    EXPECT_EQ(drive.velocity_radps(), 0);
    const bool stays = option == QuickStopOption::kRampThenStay;
    EXPECT_EQ(drive.state(), stays ? DriveState::kQuickStopActive : DriveState::kSwitchOnDisabled);
    drive.Command(0x0F);
    EXPECT_EQ(drive.state() == DriveState::kOperationEnabled, stays);
  }
}

TEST(CsvDrive, OutsideItsModeItStands) {
  CsvDrive drive = Enabled();
  drive.Step(kDt_s, 1.0, /*mode_is_csv=*/false, 0, {});
  EXPECT_EQ(drive.velocity_radps(), 0);
}

TEST(CsvDrive, WaitsSwitchedOnUntilItsOperationIsPermitted) {
  for (const int last : {0x07, 0x06}) {  // 0F is taken from either state
    CsvDrive drive = Ready();
    drive.PermitOperation(false);
    for (const int word : {0x06, last, 0x0F, 0x0F}) {
      drive.Command(static_cast<std::uint16_t>(word));
    }
    EXPECT_EQ(drive.state(), DriveState::kSwitchedOn);
    EXPECT_TRUE(drive.waits());
    drive.Step(kDt_s, 1.0, true, 0, {});
    EXPECT_EQ(drive.velocity_radps(), 0);
    drive.PermitOperation(true);
    EXPECT_EQ(drive.state(), DriveState::kOperationEnabled);
    EXPECT_FALSE(drive.waits());
    drive.PermitOperation(false);
    EXPECT_EQ(drive.state(), DriveState::kOperationEnabled) << "what is enabled stays so";
  }
}

TEST(CsvDrive, APermissionThatComesTooLateEnablesNothing) {
  for (const int word : {0x07, 0x06, 0x00}) {
    CsvDrive drive = Ready();
    drive.PermitOperation(false);
    for (const int w : {0x06, 0x0F, word}) {
      drive.Command(static_cast<std::uint16_t>(w));
    }
    EXPECT_FALSE(drive.waits()) << word;
    drive.PermitOperation(true);
    EXPECT_NE(drive.state(), DriveState::kOperationEnabled) << word;
  }
  CsvDrive drive = Ready();
  drive.PermitOperation(false);
  drive.Command(0x06);
  drive.Command(0x0F);
  drive.RaiseFault();
  drive.PermitOperation(true);
  EXPECT_EQ(drive.state(), DriveState::kFaultReaction);
}

TEST(CsvDrive, TellsOfAResetThatItCouldNotGrant) {
  CsvDrive drive = Enabled();
  drive.RaiseFault();
  drive.HoldFault(true);
  drive.Command(0x80);
  EXPECT_FALSE(drive.reset_asked()) << "still reacting";
  drive.Step(kDt_s, 0, true, 0, {});
  drive.Command(0x80);
  EXPECT_FALSE(drive.reset_asked()) << "no rising edge";
  drive.Command(0x00);
  drive.Command(0x80);
  EXPECT_TRUE(drive.reset_asked());
  EXPECT_EQ(drive.state(), DriveState::kFault);
  drive.RaiseFault();
  EXPECT_FALSE(drive.reset_asked()) << "it was about another fault";
}

// 20 seeds of 2 s: random targets flung at the limits. 1e-9: rounding of a thousand additions.
TEST(CsvDrive, NoCommandPassesASoftLimitOrTheSpeedLimit) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Rng rng(seed);
    CsvDrive drive = Enabled();
    const DriveLimits limits{.velocity_max_radps = 2.0,
                             .accel_radps2 = rng.Uniform(1, 30),
                             .quick_stop_radps2 = rng.Uniform(1, 30),
                             .lower_rad = -0.3,
                             .upper_rad = 0.2};
    double position = rng.Uniform(-0.3, 0.2);
    for (int i = 0; i < 20; ++i) {
      Turn(drive, 100, rng.Uniform(-6, 6), position, limits);
      ASSERT_LE(position, limits.upper_rad + 1e-9) << "seed " << seed;
      ASSERT_GE(position, limits.lower_rad - 1e-9) << "seed " << seed;
      ASSERT_LE(std::abs(drive.velocity_radps()), 2.0);
    }
  }
}

TEST(CsvDrive, ALimitedTargetSetsBit11AndTheWayBackIsFree) {
  CsvDrive drive = Enabled();
  double position = 0;
  const DriveLimits limits{.lower_rad = -0.1, .upper_rad = 0.1};
  Turn(drive, 10, 0.01, position, limits);
  EXPECT_EQ(drive.Statusword(true) & 0x0800, 0);
  Turn(drive, 2000, 1.0, position, limits);
  EXPECT_EQ(drive.Statusword(true) & 0x0800, 0x0800);
  EXPECT_NEAR(position, 0.1, 1e-3);
  Turn(drive, 50, -0.5, position, limits);
  EXPECT_EQ(drive.Statusword(true) & 0x0800, 0);
  EXPECT_LT(position, 0.1);
}

}  // namespace
}  // namespace pipewright::hil
