// SPDX-License-Identifier: MIT
// What the control task makes of the fixes that the mapping task hands it.
#include <gtest/gtest.h>

#include "tests/ctrl/robot_program/control_robot.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using test::ExpectWithinLimits;
using test::NoAllocScope;
using test::Robot;

/// A scan that finds the base so far from where the robot has it now.
PoseFix FixAt(const ControlReport& report, const Vector3d& away) {
  PoseFix fix{.stamp = report.state.stamp, .pose = report.state.q.head<3>() + away};
  fix.information = Vector3d(4e6, 4e6, 4e6).asDiagonal();
  return fix;
}

TEST(Correction, MovesTheRobotByThePoseThatScansTellAndNotTheWheels) {
  Robot robot;
  ASSERT_TRUE(robot.ComesUp());
  robot.Order(1);
  robot.Run(1);
  const Vector3d away(0.02, -0.01, 0.02);
  const Vector3d told = robot.report().state.q.head<3>() - robot.report().pose.by_wheels;
  ASSERT_LT(told.norm(), 1e-9) << "no fix, no correction";
  for (int k = 0; k < 60; ++k) {
    const PoseFix fix{.stamp = robot.report().state.stamp,
                      .pose = robot.report().pose.by_wheels + away,
                      .information = FixAt(robot.report(), away).information};
    {
      const NoAllocScope no_heap;
      robot.task->Correct(fix);
    }
    robot.Run(0.067);
  }
  const Vector3d moved = robot.report().state.q.head<3>() - robot.report().pose.by_wheels;
  EXPECT_LT((moved - away).head<2>().norm(), 5e-3);
  EXPECT_NEAR(moved.z(), away.z(), 5e-3);
  EXPECT_GT(robot.report().pose.fixes, 20U);
  EXPECT_TRUE(robot.report().state.valid);
}

/// However far the pose jumps, the envelope's accelerations hold.
TEST(Correction, AJumpOfThePoseSendsNoJerkToTheCommands) {
  Robot robot;
  ASSERT_TRUE(robot.ComesUp());
  robot.Order(1);
  robot.Run(1);
  ASSERT_FALSE(robot.bench.AtRest());
  double largest_m = 0;
  for (int k = 0; k < 40; ++k) {
    const double sign = k % 2 == 0 ? 1 : -1;
    const Vector3d before = robot.report().state.q.head<3>();
    robot.task->Correct(FixAt(robot.report(), sign * Vector3d(0.02, 0.02, 0.03)));
    robot.Run(0.03);
    largest_m = std::max(largest_m, (robot.report().state.q.head<3>() - before).norm());
  }
  EXPECT_GT(largest_m, 2e-3) << "it did jump";
  ExpectWithinLimits(robot.bench);
}

}  // namespace
}  // namespace pipewright
