// SPDX-License-Identifier: MIT
// At work, and from there to rest.
#include "platform/drivers/arm_driver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/platform/drivers/arm_driver_fixture.h"
#include "tests/platform/drivers/fake_devices.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using test::ArmDriverTest;

TEST_F(ArmDriverTest, EachCycleSendsSevenCommandsAndThenSync) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  ArmVector velocity;
  velocity << 0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7;
  const Time start = now_;
  Cycles(101, velocity);
  ASSERT_GE(last_.size(), 8);
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(last_[last_.size() - 8 + i].id, 0x201U + static_cast<std::uint32_t>(i));
  }
  EXPECT_EQ(last_.back(), can::Frame{.id = 0x080});
  for (int i = 0; i < 7; ++i) {
    EXPECT_NEAR(driver_.velocity_radps()[i], velocity[i], 1e-6);
    // 100 SYNCs have been sampled and reported; the last one's answer is still to come.
    EXPECT_NEAR(driver_.position_rad()[i], 0.1 * i + velocity[i], 1e-5);
  }
  EXPECT_EQ(driver_.feedback_stamp(), now_);
  EXPECT_GT(now_, start);
}

TEST_F(ArmDriverTest, WithoutAFreshCommandItSendsZero) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  Cycles(5, ArmVector::Constant(0.5));
  TxBatch out;
  driver_.Step(now_ += 10ms, out);
  int commands = 0;
  for (const can::Frame& frame : out) {
    if (frame.id > 0x200 && frame.id <= 0x207) {
      EXPECT_EQ(frame, test::Bytes(frame.id, {0x0F, 0, 0, 0, 0, 0}));
      ++commands;
    }
  }
  EXPECT_EQ(commands, 7);
}

TEST_F(ArmDriverTest, RefusesCommandsBeyondTheLimits) {
  EXPECT_EQ(driver_.Command(ArmVector::Zero()), Status::kUnavailable);
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  for (const double bad : {3.2, -3.2, std::numeric_limits<double>::quiet_NaN()}) {
    ArmVector velocity = ArmVector::Zero();
    velocity[6] = bad;
    EXPECT_EQ(driver_.Command(velocity), Status::kOutOfRange);
  }
}

TEST_F(ArmDriverTest, HostHeartbeatComesEvery100Milliseconds) {
  int beats = 0;
  for (int i = 0; i < 200; ++i) {
    Cycle();
    for (const can::Frame& frame : last_) {
      if (frame.id == 0x77F) {
        EXPECT_EQ(frame, test::Bytes(0x77F, {0x05}));
        ++beats;
      }
    }
  }
  EXPECT_EQ(beats, 20);
}

TEST_F(ArmDriverTest, StopBringsTheArmToRestAndDisablesIt) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  Cycles(10, ArmVector::Constant(0.3));
  driver_.Stop();
  ASSERT_TRUE(RunUntil(DriverPhase::kStopped, 100));
  for (const test::FakeDrive& d : drives_) {
    EXPECT_EQ(d.status, 0x0240);
    EXPECT_EQ(d.velocity, 0);
  }
  Cycles(50);
  EXPECT_EQ(driver_.phase(), DriverPhase::kStopped);
  driver_.Reset();
  EXPECT_TRUE(RunUntil(DriverPhase::kReady, 200));
}

TEST_F(ArmDriverTest, StopBeforeTheStartSendsNoCommand) {
  Cycles(3);
  driver_.Stop();
  Cycle();
  EXPECT_EQ(driver_.phase(), DriverPhase::kStopped);
  EXPECT_TRUE(std::none_of(last_.begin(), last_.end(),
                           [](const can::Frame& f) { return f.id > 0x200 && f.id < 0x208; }));
}

}  // namespace
}  // namespace pipewright
