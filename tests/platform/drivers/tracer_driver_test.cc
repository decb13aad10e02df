// SPDX-License-Identifier: MIT
#include "platform/drivers/tracer_driver.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "platform/core/rng.h"
#include "tests/platform/drivers/fake_devices.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;

class TracerDriverTest : public testing::Test {
 protected:
  /// One control cycle: hear, command, step, and the base hears in turn.
  void Cycle(double v = 0, double omega = 0) {
    now_ += 10ms;
    std::vector<can::Frame> heard;
    base_.Step(now_, heard);
    for (can::Frame& frame : heard) {
      frame.stamp = now_;
      driver_.OnFrame(frame);
    }
    if (driver_.ready()) {
      ASSERT_EQ(driver_.Command(v, omega), Status::kOk);
    }
    TxBatch out;
    driver_.Step(now_, out);
    for (const can::Frame& frame : out) {
      sent_.push_back(frame);
      base_.OnFrame(frame);
    }
  }
  void Cycles(int count, double v = 0, double omega = 0) {
    for (int i = 0; i < count; ++i) {
      Cycle(v, omega);
    }
  }
  int Sent(std::uint32_t id) const {
    int count = 0;
    for (const can::Frame& frame : sent_) {
      count += frame.id == id ? 1 : 0;
    }
    return count;
  }

  Time now_{};
  test::FakeBase base_;
  TracerDriver driver_;
  std::vector<can::Frame> sent_;
};

TEST_F(TracerDriverTest, AsksForCanModeAndThenStreamsEvery20Milliseconds) {
  Cycles(10);
  ASSERT_TRUE(driver_.ready());
  EXPECT_EQ(Sent(0x421), 1);
  EXPECT_EQ(sent_.front(), test::Bytes(0x421, {1, 0, 0, 0, 0, 0, 0, 0}));
  const int before = Sent(0x111);
  Cycles(100, 0.5, -0.3);
  EXPECT_EQ(Sent(0x111) - before, 50);
  EXPECT_EQ(sent_.back(), test::Bytes(0x111, {0x01, 0xF4, 0xFE, 0xD4, 0, 0, 0, 0}));
  EXPECT_NEAR(driver_.twist().v_mps, 0.5, 1e-12);
  EXPECT_NEAR(driver_.twist().omega_radps, -0.3, 1e-12);
  EXPECT_NEAR(driver_.odometer().left_m, -0.063, 1e-12);
  EXPECT_NEAR(driver_.battery_V(), 25.9, 1e-12);
}

TEST_F(TracerDriverTest, WithoutAFreshCommandItSendsZero) {
  Cycles(20, 0.5, 0);
  base_.v_mmps = 0;
  TxBatch out;
  for (int i = 0; i < 4; ++i) {
    driver_.Step(now_ += 10ms, out);
  }
  ASSERT_GE(out.size(), 2);
  for (const can::Frame& frame : out) {
    EXPECT_EQ(frame, test::Bytes(0x111, {0, 0, 0, 0, 0, 0, 0, 0}));
  }
}

TEST_F(TracerDriverTest, RefusesCommandsBeyondTheLimitsAndSendsZeroInstead) {
  Cycles(10);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [v, omega] : {std::pair{1.81, 0.0}, {0.0, -1.01}, {kNan, 0.0}, {0.0, kNan}}) {
    ASSERT_EQ(driver_.Command(0.5, 0.5), Status::kOk);
    EXPECT_EQ(driver_.Command(v, omega), Status::kOutOfRange);
    TxBatch out;
    driver_.Step(now_ += 20ms, out);
    ASSERT_EQ(out.size(), 1);
    EXPECT_EQ(out[0], test::Bytes(0x111, {0, 0, 0, 0, 0, 0, 0, 0}));
  }
}

TEST_F(TracerDriverTest, ABaseThatIsNotThereIsNamedAfterTheTimeout) {
  base_.silent = true;
  Cycles(502);
  EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
  EXPECT_EQ(driver_.fault().status, Status::kTimeout);
  EXPECT_EQ(driver_.fault().problem, Problem::kNotHeard);
  EXPECT_TRUE(sent_.empty());
  EXPECT_EQ(driver_.Command(0, 0), Status::kUnavailable);
}

TEST_F(TracerDriverTest, ABaseThatKeepsItsRemoteIsNotEnabled) {
  base_.obeys_mode = false;
  base_.mode = 3;
  Cycles(210);
  EXPECT_EQ(driver_.fault().problem, Problem::kNotEnabled);
  EXPECT_EQ(driver_.fault().status, Status::kTimeout);
  EXPECT_EQ(driver_.fault().detail, 3U);
  EXPECT_NEAR(Sent(0x421), 20, 1);
}

TEST_F(TracerDriverTest, ModeCodesAreThoseOfTheConfiguredManual) {
  TracerDriverConfig config;
  config.mode_codes = {"all others", {can::ControlMode::kCan, can::ControlMode::kStandby}};
  driver_ = TracerDriver(config);
  base_.obeys_mode = false;
  Cycles(10);
  EXPECT_TRUE(driver_.ready());
}

struct FaultCase {
  const char* name;
  void (*cause)(test::FakeBase& base);
  Problem problem;
  Status status;
};

TEST_F(TracerDriverTest, EachTroubleStopsTheBaseAndLatchesUntilReset) {
  const FaultCase kCases[] = {
      {"emergency stop", [](test::FakeBase& b) { b.vehicle_state = 1; }, Problem::kEmergencyStop,
       Status::kFault},
      {"exception", [](test::FakeBase& b) { b.vehicle_state = 2; }, Problem::kException,
       Status::kFault},
      {"battery", [](test::FakeBase& b) { b.errors = 0x0100; }, Problem::kUndervoltage,
       Status::kFault},
      {"remote takes over",
       [](test::FakeBase& b) {
         b.obeys_mode = false;
         b.mode = 3;
       },
       Problem::kControlLost, Status::kFault},
      {"silence", [](test::FakeBase& b) { b.silent = true; }, Problem::kStateStale, Status::kStale},
  };
  for (const FaultCase& c : kCases) {
    SCOPED_TRACE(c.name);
    base_ = {};
    driver_.Reset();
    Cycles(20, 0.5, 0);
    ASSERT_TRUE(driver_.ready());
    c.cause(base_);
    Cycles(12, 0.5, 0);
    EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
    EXPECT_EQ(driver_.fault().problem, c.problem);
    EXPECT_EQ(driver_.fault().status, c.status);
    const std::size_t before = sent_.size();
    base_ = {};
    base_.mode = 1;
    Cycles(50, 0.5, 0);  // the cause is gone
    EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
    ASSERT_GT(sent_.size(), before + 20);
    for (std::size_t i = before + 1; i < sent_.size(); ++i) {
      EXPECT_EQ(sent_[i], test::Bytes(0x111, {0, 0, 0, 0, 0, 0, 0, 0}));
    }
  }
}

struct BriefCase {
  const char* name;
  std::vector<can::Frame> frames;  ///< all between two Steps
  Problem problem;
};

can::Frame ErrorFrame(std::uint32_t error_class) {
  return {.id = error_class, .dlc = 8, .error = true};
}

TEST_F(TracerDriverTest, ATroubleThatIsOverBeforeTheNextStepLatchesAllTheSame) {
  const can::Frame well = test::Bytes(0x211, {0, 1, 1, 3, 0, 0, 0, 1});
  const BriefCase kCases[] = {
      {"emergency stop",
       {test::Bytes(0x211, {1, 1, 1, 3, 0, 0, 0, 1}), well},
       Problem::kEmergencyStop},
      {"exception", {test::Bytes(0x211, {2, 1, 1, 3, 0, 0, 0, 1}), well}, Problem::kException},
      {"battery", {test::Bytes(0x211, {0, 1, 1, 3, 1, 0, 0, 1}), well}, Problem::kUndervoltage},
      {"remote", {test::Bytes(0x211, {0, 3, 1, 3, 0, 0, 0, 1}), well}, Problem::kControlLost},
      {"bus off", {ErrorFrame(0x040)}, Problem::kBusOff},
      {"restarted", {ErrorFrame(0x100)}, Problem::kBusOff},
      {"with others", {ErrorFrame(0x0C8)}, Problem::kBusOff},
  };
  for (const BriefCase& c : kCases) {
    SCOPED_TRACE(c.name);
    base_ = {};
    driver_.Reset();
    Cycles(20, 0.5, 0);
    ASSERT_TRUE(driver_.ready());
    for (can::Frame frame : c.frames) {
      frame.stamp = now_;
      driver_.OnFrame(frame);
    }
    Cycles(20, 0.5, 0);
    EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
    EXPECT_EQ(driver_.fault().problem, c.problem) << Name(driver_.fault().problem);
    EXPECT_EQ(base_.v_mmps, 0);
  }
}

TEST_F(TracerDriverTest, OtherErrorFramesAreCountedAndChangeNothing) {
  Cycles(20, 0.5, 0);
  // transmit timeout, arbitration, controller (warning, passive), protocol, transceiver, no
  // acknowledge, bus error, error counters
  for (const std::uint32_t error_class : {0x1, 0x2, 0x4, 0x8, 0x10, 0x20, 0x80, 0x200}) {
    driver_.OnFrame(ErrorFrame(error_class));
  }
  Cycles(20, 0.5, 0);
  EXPECT_TRUE(driver_.ready());
  EXPECT_EQ(driver_.rx_counters().error_frame, 8U);
}

TEST_F(TracerDriverTest, AFrameOlderThanOneBeforeItIsCountedAndIgnored) {
  Cycles(20, 0.5, 0);
  can::Frame old = test::Bytes(0x221, {0x01, 0, 0, 0, 0, 0, 0, 0});
  old.stamp = now_ - 30ms;
  driver_.OnFrame(old);
  old = test::Bytes(0x211, {1, 1, 1, 3, 0, 0, 0, 1});
  old.stamp = now_ - 30ms;
  driver_.OnFrame(old);
  EXPECT_EQ(driver_.late(), 2U);
  EXPECT_NEAR(driver_.twist().v_mps, 0.5, 1e-12);
  Cycles(2, 0.5, 0);
  EXPECT_TRUE(driver_.ready());
}

TEST_F(TracerDriverTest, AStateOfTheFutureIsNoState) {
  Cycles(20, 0.5, 0);
  can::Frame ahead = test::Bytes(0x221, {0x01, 0xF4, 0, 0, 0, 0, 0, 0});
  ahead.stamp = now_ + std::chrono::hours(1);
  driver_.OnFrame(ahead);
  Cycle();
  EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
  EXPECT_EQ(driver_.fault().problem, Problem::kStateAhead);
}

TEST_F(TracerDriverTest, SendsZeroAtOnceWhenTheClockIsSetBack) {
  Cycles(20, 0.5, 0);
  now_ -= 3000ms;
  TxBatch out;
  for (int i = 0; i < 4; ++i) {
    driver_.Step(now_ += 10ms, out);
  }
  EXPECT_EQ(driver_.fault().problem, Problem::kStateAhead);
  ASSERT_GE(out.size(), 2);
  EXPECT_EQ(out[0], test::Bytes(0x111, {0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST_F(TracerDriverTest, StopWaitsForRestAndHandsControlBack) {
  Cycles(20, 0.5, 0.2);
  ASSERT_EQ(base_.v_mmps, 500);
  driver_.Stop();
  Cycles(20);
  EXPECT_EQ(driver_.phase(), DriverPhase::kStopped);
  EXPECT_EQ(base_.v_mmps, 0);
  EXPECT_EQ(base_.mode, 0);
  EXPECT_EQ(sent_.back(), test::Bytes(0x421, {0, 0, 0, 0, 0, 0, 0, 0}));
  const std::size_t before = sent_.size();
  Cycles(10);
  EXPECT_EQ(sent_.size(), before);
}

TEST_F(TracerDriverTest, AnyTrafficIsTakenWithoutHarmAndMovesNothing) {
  Rng rng(1);
  for (int i = 0; i < 20'000; ++i) {
    can::Frame frame{.id = static_cast<std::uint32_t>(rng.Index(0x800)),
                     .dlc = static_cast<std::uint8_t>(rng.Index(9))};
    for (std::uint8_t& byte : frame.data) {
      byte = static_cast<std::uint8_t>(rng.Index(256));
    }
    frame.stamp = now_;
    driver_.OnFrame(frame);
    TxBatch out;
    driver_.Step(now_ += 1ms, out);
    for (const can::Frame& f : out) {
      if (f.id == 0x111) {
        EXPECT_EQ(f, test::Bytes(0x111, {0, 0, 0, 0, 0, 0, 0, 0}));
      }
    }
    if (driver_.phase() == DriverPhase::kFault) {
      EXPECT_NE(Name(driver_.fault().problem), "");
      driver_.Reset();
    }
  }
}

}  // namespace
}  // namespace pipewright
