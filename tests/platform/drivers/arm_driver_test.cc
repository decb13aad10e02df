// SPDX-License-Identifier: MIT
#include "platform/drivers/arm_driver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "platform/core/rng.h"
#include "tests/platform/drivers/fake_devices.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;

class ArmDriverTest : public testing::Test {
 protected:
  ArmDriverTest() { Renew(); }

  void Renew() {
    for (int i = 0; i < 7; ++i) {
      drives_[i] = {};
      drives_[i].node = i + 1;
      drives_[i].position = 0.1 * i;
    }
  }
  void Cycle(const ArmVector& velocity = ArmVector::Zero()) {
    now_ += 10ms;
    std::vector<can::Frame> heard;
    for (test::FakeDrive& drive : drives_) {
      drive.Step(now_, heard);
    }
    for (can::Frame& frame : heard) {
      frame.stamp = now_;
      driver_.OnFrame(frame);
    }
    if (driver_.ready()) {
      ASSERT_EQ(driver_.Command(velocity), Status::kOk);
    }
    last_.clear();
    driver_.Step(now_, last_);
    for (const can::Frame& frame : last_) {
      for (test::FakeDrive& drive : drives_) {
        drive.OnFrame(frame);
      }
    }
  }
  void Cycles(int count, const ArmVector& velocity = ArmVector::Zero()) {
    for (int i = 0; i < count; ++i) {
      Cycle(velocity);
    }
  }
  bool RunUntil(DriverPhase phase, int cycles) {
    for (int i = 0; i < cycles && driver_.phase() != phase; ++i) {
      Cycle();
    }
    return driver_.phase() == phase;
  }

  Time now_{};
  std::array<test::FakeDrive, 7> drives_;
  ArmDriver driver_;
  TxBatch last_;
};

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

TEST_F(ArmDriverTest, AFaultLeftFromBeforeIsResetOnceByARisingEdge) {
  drives_[3].status = 0x0218;
  ASSERT_TRUE(RunUntil(DriverPhase::kReady, 200));
  EXPECT_EQ(drives_[3].resets, 1);
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
