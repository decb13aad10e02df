// SPDX-License-Identifier: MIT
// Buses that have more to say than a cycle can hear, and buses that do not take what is sent.
#include "ctrl/robot_program/bus_cycle.h"

#include <gtest/gtest.h>

#include "tests/ctrl/robot_program/control_robot.h"

namespace pipewright {
namespace {

using test::Robot;

/// A port behind which more may wait, and that may take nothing.
struct BadPort {
  can::LoopbackBus::Port& port;
  int junk = 0;  ///< frames of nobody's ahead of the port's own
  bool full = false;
  int received = 0;

  bool Receive(can::Frame& frame) {
    if (junk > 0) {
      --junk;
      ++received;
      frame = {.id = 0x7A0, .dlc = 8};
      return true;
    }
    return port.Receive(frame);
  }
  Status Send(const can::Frame& frame) { return full ? Status::kFull : port.Send(frame); }
};

struct Bench {
  /// One cycle of 10 ms; before it the arm's bus delivers `junk` frames more.
  void Cycle(int junk = 0, bool full = false) {
    BadPort base{robot.bench.base(), 0, base_full};
    BadPort arm{robot.bench.arm(), left + junk, full};
    TxBatch base_out;
    TxBatch arm_out;
    ReceiveFrames(base, arm, *robot.task, counters);
    left = arm.junk;
    received = arm.received;
    robot.task->Step(robot.bench.now(), robot.scene, robot.field, robot.goal, base_out, arm_out);
    SendFrames(base, base_out, *robot.task, counters);
    SendFrames(arm, arm_out, *robot.task, counters);
    for (int i = 0; i < 10; ++i) {
      robot.bench.Tick();
    }
  }
  void Cycles(int count) {
    for (int i = 0; i < count; ++i) {
      Cycle();
    }
  }
  double Speed() const { return robot.report().sent.norm(); }

  /// Under way to a goal.
  bool Moves() {
    Cycles(200);
    robot.Order(1);
    Cycles(60);
    return robot.report().phase == ControlPhase::kRunning && Speed() > 0.1;
  }

  Robot robot;
  BusCounters counters;
  int left = 0;
  int received = 0;
  bool base_full = false;
};

TEST(BusCycle, ReadsABoundedNumberAndBrakesUntilTheNewestFrameWasReached) {
  Bench bench;
  ASSERT_TRUE(bench.Moves());
  ASSERT_EQ(bench.counters.backlogs, 0U);
  const double before = bench.Speed();
  bench.Cycle(3 * kFramesPerCycle);
  EXPECT_EQ(bench.received, kFramesPerCycle);
  EXPECT_EQ(bench.counters.backlogs, 1U);
  EXPECT_FALSE(bench.robot.report().state.valid);
  EXPECT_LT(bench.Speed(), before);
  bench.Cycle();
  bench.Cycle();
  EXPECT_EQ(bench.counters.backlogs, 3U);
  EXPECT_FALSE(bench.robot.report().state.valid);
  bench.Cycles(6);  // the drives' own frames at last, and 50 ms more
  EXPECT_EQ(bench.counters.backlogs, 3U);
  EXPECT_TRUE(bench.robot.report().state.valid);
  bench.Cycles(20);
  EXPECT_GT(bench.Speed(), 0.1);
}

TEST(BusCycle, ANodeThatNeverFallsSilentStopsTheRobot) {
  Bench bench;
  ASSERT_TRUE(bench.Moves());
  for (int i = 0; i < 100; ++i) {
    bench.Cycle(2 * kFramesPerCycle);
    ASSERT_LE(bench.received, kFramesPerCycle);
  }
  EXPECT_TRUE(bench.robot.bench.AtRest());
}

TEST(BusCycle, ReadsAllThatABusCanCarryInTheLongestPeriod) {
  constexpr int kLeastBits = 47;  // of a frame without data: ISO 11898-1, intermission included
  EXPECT_GT(kFramesPerCycle, 1'000'000 / kLeastBits * 20 / 1000);
}

/// The base is sent to in every second cycle only.
TEST(BusCycle, ABaseThatTakesNothingStopsTheArmToo) {
  Bench bench;
  ASSERT_TRUE(bench.Moves());
  for (int i = 0; i < 150; ++i) {
    bench.base_full = true;
    bench.Cycle();
  }
  EXPECT_TRUE(bench.robot.bench.AtRest());
}

TEST(BusCycle, BrakesAfterACycleWhoseFramesWereNotTaken) {
  Bench bench;
  ASSERT_TRUE(bench.Moves());
  const double before = bench.Speed();
  bench.Cycle(0, true);
  EXPECT_EQ(bench.counters.send_failures, 9U);  // seven commands, SYNC, and a heartbeat's turn
  bench.Cycle(0, true);
  EXPECT_FALSE(bench.robot.report().state.valid);
  EXPECT_LT(bench.Speed(), before);
  for (int i = 0; i < 150; ++i) {
    bench.Cycle(0, true);
  }
  EXPECT_TRUE(bench.robot.bench.AtRest());
}

}  // namespace
}  // namespace pipewright
