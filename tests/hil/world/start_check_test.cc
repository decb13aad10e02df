// SPDX-License-Identifier: MIT
#include "hil/world/start_check.h"

#include <gtest/gtest.h>

#include <numbers>

namespace pipewright::hil {
namespace {

/// A ball of 0.1 m on a joint that lifts it: its centre is at (x, y, joint).
RobotBodies Ball() {
  RobotBodies robot;
  robot.links = 1;
  robot.joint_min_rad = {0.2};
  robot.joint_max_rad = {2.0};
  Body body;
  body.name = "ball";
  body.group = 1;
  body.shape = Shape::Sphere(0.1);
  robot.bodies.push_back(body);
  robot.forward = [](double x, double y, double, std::span<const double> joints,
                     RobotBodies::Pose& pose) {
    pose.X_WL.assign(1, Isometry3d(Eigen::Translation3d(x, y, joints[0])));
  };
  return robot;
}

StartCheck Check(double x_m, std::vector<double> joints_rad, double clearance_m = 0.1) {
  Scenario scenario;
  scenario.start.x_m = x_m;
  scenario.start.joints_rad = std::move(joints_rad);
  scenario.start.clearance_m = clearance_m;
  scenario.start.where = "t.toml:5:1: start";
  Solid wall;  // x <= 0
  wall.kind = SolidKind::kPlane;
  wall.name = "wall";
  wall.X_WG.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()).toRotationMatrix();
  scenario.solids.push_back(wall);
  const double home = 1;
  return CheckStart(scenario, Ball(), {&home, 1});
}

TEST(StartCheck, AcceptsAStartAtTheClearanceItStates) {
  for (const StartCheck& check : {Check(0.2001, {}), Check(5, {0.2}), Check(5, {2.0})}) {
    EXPECT_TRUE(check.errors.empty());
    EXPECT_TRUE(check.warnings.empty());
  }
}

TEST(StartCheck, RefusesJointsBeyondTheirLimits) {
  for (const double joint : {0.19, 2.01}) {
    const StartCheck check = Check(5, {joint});
    ASSERT_EQ(check.errors.size(), 1U);
    EXPECT_NE(check.errors[0].find("t.toml:5:1: start.joints_rad: joint 1 at"), std::string::npos)
        << check.errors[0];
  }
}

TEST(StartCheck, RefusesARobotThatTouches) {
  const StartCheck check = Check(0.05, {});
  ASSERT_EQ(check.errors.size(), 1U);
  EXPECT_NE(check.errors[0].find("ball - wall"), std::string::npos) << check.errors[0];
}

TEST(StartCheck, WarnsOfWhatIsNearerThanTheOperatorSays) {
  const StartCheck check = Check(0.15, {});
  EXPECT_TRUE(check.errors.empty());
  ASSERT_EQ(check.warnings.size(), 1U);
  EXPECT_NE(check.warnings[0].find("start.clearance_m: is 0.1, but wall is 0.05"),
            std::string::npos)
      << check.warnings[0];
  EXPECT_TRUE(Check(0.15, {}, 0.04).warnings.empty());
}

}  // namespace
}  // namespace pipewright::hil
