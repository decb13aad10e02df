// SPDX-License-Identifier: MIT
// Every number of the control task's configuration, spoilt in every way: refused at start.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>

#include "tests/ctrl/robot_program/config_fields.h"
#include "tests/ctrl/robot_program/control_robot.h"

namespace pipewright {
namespace {

using test::Field;
using test::Robot;

TEST(ControlTaskConfig, OfEveryFieldOnlyANumberToReckonWithIsTaken) {
  const ControlTaskConfig good = Robot::Config();
  ASSERT_TRUE(Valid(good));
  for (const Field& field : test::Fields()) {
    for (const double bad : test::kUnusable) {
      SCOPED_TRACE(testing::Message() << field.name << " = " << bad);
      ControlTaskConfig config = good;
      *field.of(config) = bad;
      EXPECT_FALSE(Valid(config));
    }
  }
  for (const test::DurationField& field : test::DurationFields()) {
    for (const Duration bad : {Duration::max(), Duration::min(), -Duration(1), Duration::zero()}) {
      SCOPED_TRACE(testing::Message() << field.name << " = " << bad.count() << " ns");
      ControlTaskConfig config = good;
      *field.of(config) = bad;
      EXPECT_FALSE(Valid(config));
    }
  }
}

TEST(ControlTaskConfig, AtATaskThatRefusesItsConfigurationNothingMoves) {
  // One number of each part.
  for (const auto& spoil : {std::function<void(ControlTaskConfig&)>(
                                [](ControlTaskConfig& c) { c.law.constraints.consider_m = 1e300; }),
                            std::function<void(ControlTaskConfig&)>([](ControlTaskConfig& c) {
                              c.start.phi_rad = std::numeric_limits<double>::quiet_NaN();
                            }),
                            std::function<void(ControlTaskConfig&)>(
                                [](ControlTaskConfig& c) { c.base.standstill_mps = 5e-324; })}) {
    ControlTaskConfig config = Robot::Config();
    spoil(config);
    Robot robot(config);
    EXPECT_EQ(robot.task->status(), Status::kOutOfRange);
    robot.Run(1);
    robot.Order(1);
    robot.Run(1);
    EXPECT_TRUE(robot.bench.AtRest());
    for (const test::SentJoint& sent : robot.bench.joints) {
      ASSERT_EQ(sent.velocity_uradps, 0);
    }
    for (const test::SentTwist& sent : robot.bench.twists) {
      ASSERT_TRUE(sent.v_mmps == 0 && sent.omega_mradps == 0);
    }
  }
}

}  // namespace
}  // namespace pipewright
