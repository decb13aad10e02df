// SPDX-License-Identifier: MIT
// What goes wrong at work: the drives, their bus, and what they say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "platform/core/rng.h"
#include "platform/drivers/arm_driver.h"
#include "tests/platform/drivers/arm_driver_fixture.h"
#include "tests/platform/drivers/fake_devices.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using test::ArmDriverTest;

struct RunCase {
  const char* name;
  void (*cause)(test::FakeDrive& drive);
  Problem problem;
  Status status;
};

TEST_F(ArmDriverTest, EachTroubleAtWorkQuickStopsAllDrivesAndLatches) {
  const RunCase kCases[] = {
      {"silent", [](test::FakeDrive& d) { d.silent = true; }, Problem::kStateStale, Status::kStale},
      {"emergency",
       [](test::FakeDrive& d) {
         d.Say(test::Bytes(0x082, {0x30, 0x81, 0x10, 0, 0, 0, 0, 0}));
       },
       Problem::kEmergencyMessage, Status::kFault},
      {"fault", [](test::FakeDrive& d) { d.SetStatus(0x0218); }, Problem::kDriveFault,
       Status::kFault},
      {"switched off", [](test::FakeDrive& d) { d.SetStatus(0x0233); }, Problem::kControlLost,
       Status::kFault},
      {"restart", [](test::FakeDrive& d) { d.Say(test::Bytes(0x702, {0x00})); }, Problem::kRebooted,
       Status::kFault},
      {"left operational", [](test::FakeDrive& d) { d.Say(test::Bytes(0x702, {0x04})); },
       Problem::kControlLost, Status::kFault},
  };
  for (const RunCase& c : kCases) {
    SCOPED_TRACE(c.name);
    Renew();
    driver_.Reset();
    ASSERT_TRUE(RunUntil(DriverPhase::kReady, 200));
    Cycles(10, ArmVector::Constant(0.3));
    c.cause(drives_[1]);
    Cycles(8, ArmVector::Constant(0.3));
    EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
    EXPECT_EQ(driver_.fault().problem, c.problem) << Name(driver_.fault().problem);
    EXPECT_EQ(driver_.fault().status, c.status);
    EXPECT_EQ(driver_.fault().node, 2);
    for (const can::Frame& frame : last_) {
      if (frame.id > 0x200 && frame.id <= 0x207) {
        EXPECT_EQ(frame, test::Bytes(frame.id, {0x02, 0, 0, 0, 0, 0}));
      }
    }
    for (int i : {0, 2, 6}) {
      EXPECT_EQ(drives_[i].status, 0x0240);
      EXPECT_EQ(drives_[i].velocity, 0);
    }
    Cycles(20);
    EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
  }
}

struct BriefCase {
  const char* name;
  std::vector<can::Frame> frames;  ///< all between two Steps; what drive 2 says last is well
  Problem problem;
  int node;
};

TEST_F(ArmDriverTest, ATroubleThatIsOverBeforeTheNextStepLatchesAllTheSame) {
  const can::Frame enabled = test::Bytes(0x282, {0x37, 0x12, 9});
  const BriefCase kCases[] = {
      {"emergency and its end",
       {test::Bytes(0x082, {0x30, 0x81, 0x10, 0, 0, 0, 0, 0}),
        test::Bytes(0x082, {0, 0, 0, 0, 0, 0, 0, 0})},
       Problem::kEmergencyMessage,
       2},
      {"fault and reset", {test::Bytes(0x282, {0x18, 0x02, 9}), enabled}, Problem::kDriveFault, 2},
      {"switched off and on",
       {test::Bytes(0x282, {0x33, 0x02, 9}), enabled},
       Problem::kControlLost,
       2},
      {"another mode", {test::Bytes(0x282, {0x37, 0x12, 8}), enabled}, Problem::kControlLost, 2},
      {"left operational",
       {test::Bytes(0x702, {0x04}), test::Bytes(0x702, {0x05})},
       Problem::kControlLost,
       2},
      {"bus off", {{.id = 0x040, .dlc = 8, .error = true}}, Problem::kBusOff, 0},
      {"restarted", {{.id = 0x100, .dlc = 8, .error = true}}, Problem::kBusOff, 0},
  };
  for (const BriefCase& c : kCases) {
    SCOPED_TRACE(c.name);
    Renew();
    driver_.Reset();
    ASSERT_TRUE(RunUntil(DriverPhase::kReady, 200));
    Cycles(10, ArmVector::Constant(0.3));
    for (can::Frame frame : c.frames) {
      frame.stamp = now_;
      driver_.OnFrame(frame);
    }
    Cycles(8);
    EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
    EXPECT_EQ(driver_.fault().problem, c.problem) << Name(driver_.fault().problem);
    EXPECT_EQ(driver_.fault().node, c.node);
    for (const test::FakeDrive& d : drives_) {
      EXPECT_EQ(d.velocity, 0);
    }
  }
}

TEST_F(ArmDriverTest, OtherErrorFramesAreCountedAndChangeNothing) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  for (const std::uint32_t error_class : {0x1, 0x2, 0x4, 0x8, 0x10, 0x20, 0x80, 0x200}) {
    driver_.OnFrame({.id = error_class, .dlc = 8, .error = true});
  }
  Cycles(20);
  EXPECT_TRUE(driver_.ready());
  EXPECT_EQ(driver_.rx_counters().error_frame, 8U);
}

TEST_F(ArmDriverTest, AReadingOlderThanOneBeforeItIsCountedAndIgnored) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  const double before = driver_.position_rad()[4];
  can::Frame old = test::Bytes(0x185, {0x40, 0x42, 0x0F, 0, 0, 0, 0, 0});  // 1 rad
  old.stamp = now_ - 15ms;
  driver_.OnFrame(old);
  EXPECT_EQ(driver_.late(), 1U);
  EXPECT_EQ(driver_.position_rad()[4], before);
}

TEST_F(ArmDriverTest, AReadingThatNoJointCanHaveIsCountedAndIgnored) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  const double before = driver_.position_rad()[4];  // 0.4 rad
  const auto read = [&](std::vector<int> bytes) {
    can::Frame frame = test::Bytes(0x185, std::move(bytes));
    frame.stamp = now_;
    driver_.OnFrame(frame);
  };
  read({0x40, 0x42, 0x0F, 0, 0, 0, 0, 0});           // 1 rad: 0.6 rad in no time
  read({0x80, 0x1A, 0x06, 0, 0x00, 0x00, 0x00, 1});  // 0.4 rad, at 16.8 rad/s
  EXPECT_EQ(driver_.unlikely(), 2U);
  EXPECT_EQ(driver_.position_rad()[4], before);
  read({0x90, 0x41, 0x06, 0, 0, 0, 0, 0});  // 0.41 rad
  EXPECT_EQ(driver_.unlikely(), 2U);
  EXPECT_NEAR(driver_.position_rad()[4], 0.41, 1e-9);
}

TEST_F(ArmDriverTest, AReadingOfTheFutureIsNoReading) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  can::Frame ahead = test::Bytes(0x185, {0x40, 0x42, 0x0F, 0, 0, 0, 0, 0});
  ahead.stamp = now_ + std::chrono::hours(1);
  driver_.OnFrame(ahead);
  Cycle();
  EXPECT_EQ(driver_.phase(), DriverPhase::kFault);
  EXPECT_EQ(driver_.fault().problem, Problem::kStateAhead);
  EXPECT_EQ(driver_.fault().node, 5);
}

TEST_F(ArmDriverTest, ALostHeartbeatIsSeenThoughFeedbackGoesOn) {
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 100));
  for (int i = 0; i < 40 && driver_.ready(); ++i) {
    Cycle();
    auto& outbox = drives_[6].outbox;
    std::erase_if(outbox, [](const can::Frame& f) { return f.id == 0x707; });
    now_ += 10ms;
    std::vector<can::Frame> heard;
    for (test::FakeDrive& d : drives_) {
      d.Step(now_ + 1ms, heard);  // off the 100 ms grid: no heartbeat of any
    }
    for (can::Frame& frame : heard) {
      frame.stamp = now_;
      driver_.OnFrame(frame);
    }
    for (int id = 1; id < 7; ++id) {
      can::Frame beat = test::Bytes(0x700 + static_cast<std::uint32_t>(id), {0x05});
      beat.stamp = now_;
      driver_.OnFrame(beat);
    }
    TxBatch out;
    driver_.Step(now_, out);
    for (const can::Frame& frame : out) {
      for (test::FakeDrive& d : drives_) {
        d.OnFrame(frame);
      }
    }
    now_ += 5ms;  // the fakes' own heartbeat instants are never met again
  }
  EXPECT_EQ(driver_.fault().problem, Problem::kHeartbeatLost);
  EXPECT_EQ(driver_.fault().node, 7);
}

TEST_F(ArmDriverTest, AnyTrafficIsTakenWithoutHarmAndMovesNothing) {
  Rng rng(2);
  for (int i = 0; i < 30'000; ++i) {
    can::Frame frame{.id = static_cast<std::uint32_t>(rng.Index(0x800)),
                     .dlc = static_cast<std::uint8_t>(rng.Index(9))};
    for (std::uint8_t& byte : frame.data) {
      byte = static_cast<std::uint8_t>(rng.Index(4) != 0 ? 0 : rng.Index(256));
    }
    frame.stamp = now_;
    driver_.OnFrame(frame);
    TxBatch out;
    driver_.Step(now_ += 1ms, out);
    for (const can::Frame& f : out) {
      if (f.id > 0x200 && f.id <= 0x207) {
        EXPECT_EQ(f.data[2] | f.data[3] | f.data[4] | f.data[5], 0);
      }
    }
    if (driver_.phase() == DriverPhase::kFault && rng.Index(50) == 0) {
      driver_.Reset();
    }
  }
}

}  // namespace
}  // namespace pipewright
