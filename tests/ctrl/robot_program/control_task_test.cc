// SPDX-License-Identifier: MIT
// The control task against the emulated devices: what it makes of them, and what it lets onto the
// wire.
#include "ctrl/robot_program/control_task.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "tests/ctrl/robot_program/control_robot.h"

namespace pipewright {
namespace {

using test::ExpectWithinLimits;
using test::Robot;
using test::SentJoint;
using test::SentTwist;

TEST(ControlTask, BringsTheDevicesUpAndKnowsWhereTheyAre) {
  Robot robot;
  EXPECT_EQ(robot.task->status(), Status::kOk);
  EXPECT_EQ(robot.report().phase, ControlPhase::kStarting);
  ASSERT_TRUE(robot.ComesUp());
  robot.Run(0.1);
  EXPECT_TRUE(robot.report().state.valid);
  EXPECT_LT((robot.report().state.q.tail<kArmJoints>() - robot.bench.plant().joints_rad()).norm(),
            1e-5);
  EXPECT_TRUE(robot.bench.AtRest());  // without a goal it stands
}

TEST(ControlTask, BringsTheSensorToItsGoalAndSendsNothingOutsideItsLimits) {
  Robot robot;
  ASSERT_TRUE(robot.ComesUp());
  for (const std::uint32_t id : {1U, 2U}) {
    robot.Order(id, id == 1 ? 1 : -1);
    ASSERT_TRUE(robot.Run(20, [&] { return robot.report().progress.state == GoalState::kReached; }))
        << "error " << robot.report().progress.error;
    EXPECT_EQ(robot.report().progress.id, id);
    // Where it really is, by KDL on the URDF: the law's tolerance, and 5 mm for odometry.
    const Isometry3d& X_WS = robot.bench.plant().X_WS();
    EXPECT_LT((X_WS.translation() - robot.goal.p_WS).norm(), 0.015);
    EXPECT_LT((X_WS.linear().col(2) - robot.goal.z_WS).norm(), 0.015);
  }
  ExpectWithinLimits(robot.bench);
  EXPECT_EQ(robot.bench.plant().hard_stops(), 0);
  // It did use its speed: the limits above were near enough to be met.
  int fastest_mmps = 0;
  for (const SentTwist& sent : robot.bench.twists) {
    fastest_mmps = std::max(fastest_mmps, std::abs(sent.v_mmps));
  }
  EXPECT_GT(fastest_mmps, 200);
}

TEST(ControlTask, ComesToRestAndDisablesTheDevicesWhenAskedToStop) {
  Robot robot;
  ASSERT_TRUE(robot.ComesUp());
  robot.Order(1);
  robot.Run(1);
  ASSERT_FALSE(robot.bench.AtRest());
  robot.task->Stop();
  EXPECT_TRUE(robot.Run(4, [&] { return robot.report().phase == ControlPhase::kStopped; }));
  robot.Run(0.1);
  robot.ExpectStandstill();
  for (int i = 0; i < kArmJoints; ++i) {
    EXPECT_EQ(robot.bench.devices().joint(i).drive_state(), hil::DriveState::kSwitchOnDisabled);
  }
}

TEST(ControlTask, SlowsDownAtOnceWhenNothingIsHeardAnyMore) {
  Robot robot;
  ASSERT_TRUE(robot.ComesUp());
  robot.Order(1);
  robot.Run(1);
  const double before = robot.report().sent.norm();
  ASSERT_GT(before, 0.1);
  robot.deaf = true;
  robot.Run(0.06);  // past the state's timeout of 50 ms
  const EnvelopeCounters& counters = robot.task->envelope_counters();
  EXPECT_GT(counters.stale + counters.invalid_state, 0U);
  double last = robot.report().sent.norm();
  for (int i = 0; i < 60; ++i) {
    robot.Run(0.01);
    EXPECT_LE(robot.report().sent.norm(), last);
    last = robot.report().sent.norm();
  }
  EXPECT_EQ(last, 0);
  robot.Run(0.5);
  EXPECT_EQ(robot.report().phase, ControlPhase::kFault);
  robot.ExpectStandstill();
}

TEST(ControlTask, AJointThatFallsSilentStopsTheWholeRobotAndIsNamed) {
  for (const int device : {0, 1, 6}) {
    SCOPED_TRACE(device);
    Robot robot;
    ASSERT_TRUE(robot.ComesUp());
    robot.Order(1);
    robot.Run(1);
    ASSERT_FALSE(robot.bench.AtRest());
    robot.bench.devices().Silence(device, robot.bench.now());
    EXPECT_TRUE(robot.Run(0.5, [&] { return robot.report().phase == ControlPhase::kFault; }));
    robot.Run(2);
    robot.ExpectStandstill();
    if (device == 0) {
      EXPECT_EQ(robot.report().base_fault.problem, Problem::kStateStale);
    } else {
      EXPECT_EQ(robot.report().arm_fault.node, device);
    }
  }
}

TEST(ControlTask, StaysStoppedAfterAnEmergencyStopUntilAnOperatorSaysSo) {
  Robot robot;
  ASSERT_TRUE(robot.ComesUp());
  robot.Order(1);
  robot.Run(1);
  robot.bench.devices().tracer().PressEmergencyStop(true);
  robot.Run(1.5);
  EXPECT_TRUE(robot.report().state.emergency_stop);
  robot.ExpectStandstill();
  EXPECT_EQ(robot.task->Rearm(), Status::kFault);  // still pressed

  robot.bench.devices().tracer().PressEmergencyStop(false);
  robot.Run(2);
  robot.ExpectStandstill();  // the goal still stands, and so does the robot
  EXPECT_EQ(robot.task->Rearm(), Status::kOk);
  EXPECT_TRUE(robot.ComesUp());
  robot.Order(2);
  EXPECT_TRUE(robot.Run(20, [&] { return robot.report().progress.state == GoalState::kReached; }));
}

TEST(ControlTask, CommandsZeroWhenItsConfigurationIsNotValid) {
  ControlTaskConfig config = Robot::Config();
  config.law.constraints.alpha = 0.3;  // not convex
  Robot robot(config);
  EXPECT_EQ(robot.task->status(), Status::kOutOfRange);
  EXPECT_TRUE(robot.ComesUp());
  robot.Order(1);
  robot.Run(2);
  for (const SentTwist& sent : robot.bench.twists) {
    ASSERT_TRUE(sent.v_mmps == 0 && sent.omega_mradps == 0);
  }
  for (const SentJoint& sent : robot.bench.joints) {
    ASSERT_EQ(sent.velocity_uradps, 0);
  }
}

TEST(EnvelopeOf, GivesTheEnvelopeTheRobotsOwnLimits) {
  ControlTaskConfig config = Robot::Config();
  config.law.constraints.period_s = 0.004;
  const EnvelopeConfig e = EnvelopeOf(TracerUf7(), config);
  EXPECT_TRUE(Valid(e));
  EXPECT_EQ(e.period, std::chrono::milliseconds(4));
  EXPECT_EQ(e.u_max(0), 0.4);
  EXPECT_EQ(e.u_max(1), 1.0);
  EXPECT_EQ(e.u_max(5), 1.0);  // at which it is operated, not what the joint could do
  EXPECT_EQ(e.a_max(0), 0.8);
  EXPECT_EQ(e.q_min(3), -0.191986);  // of joint 4, as the vendor gives it
  EXPECT_EQ(e.q_max(3), 3.92699);
}

}  // namespace
}  // namespace pipewright
