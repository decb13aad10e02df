// SPDX-License-Identifier: MIT
#include "hil/world/clearance.h"

#include <gtest/gtest.h>

#include "hil/plant/plant.h"
#include "hil/plant/robot_description.h"
#include "hil/world/convex_distance.h"
#include "hil/world/scenario.h"
#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

RobotBodies TheRobot() { return RobotBodiesOf(TracerUf7Description()); }

std::vector<double> DrawJoints(const RobotBodies& robot, Rng& rng) {
  std::vector<double> joints;
  for (std::size_t i = 0; i < robot.joint_min_rad.size(); ++i) {
    joints.push_back(rng.Uniform(robot.joint_min_rad[i], robot.joint_max_rad[i]));
  }
  return joints;
}

// Oracle: the plant's own kinematics, by KDL.
TEST(RobotBodiesOf, PutsTheLinksWhereThePlantDoes) {
  const RobotDescription description = TracerUf7Description();
  const RobotBodies robot = RobotBodiesOf(description);
  Rng rng(31);
  RobotBodies::Pose pose;
  for (int i = 0; i < 100; ++i) {
    const std::vector<double> joints = DrawJoints(robot, rng);
    const double x = rng.Uniform(-1, 1);
    const double yaw = rng.Uniform(-3, 3);
    robot.forward(x, 0.5, yaw, joints, pose);
    const Plant plant(description, {x, 0.5, yaw}, Vec<kPlantJoints>(joints.data()));
    for (int link = 0; link < robot.links; ++link) {
      ASSERT_TRUE(pose.X_WL[link].isApprox(plant.X_WL(link), 1e-9)) << description.links[link];
    }
    ASSERT_TRUE(pose.p_WP.isApprox(plant.p_WP(), 1e-9));
  }
}

TEST(RobotBodiesOf, GroupsFixedLinksAndJoinsTheOthersInAChain) {
  const RobotBodies robot = TheRobot();
  EXPECT_EQ(robot.joint_min_rad.size(), 7U);
  ASSERT_EQ(robot.adjacent_groups.size(), 7U);
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(robot.adjacent_groups[i], (std::pair{i, i + 1}));
  }
  for (const Body& body : robot.bodies) {
    if (body.name.starts_with("base_link") || body.name.starts_with("arm_base")) {
      EXPECT_EQ(body.group, 0) << body.name;
    }
    if (body.name.starts_with("link7") || body.name.starts_with("tool")) {
      EXPECT_EQ(body.group, 7) << body.name;
    }
  }
}

// Oracle: every pair, measured without any bound.
TEST(ClearanceMeter, EqualsTheMinimumOverAllPairs) {
  const Scenario scenario = *LoadScenario("pipes3").scenario;
  const RobotBodies robot = TheRobot();
  ClearanceMeter meter(scenario.solids, robot);
  Rng rng(32);
  RobotBodies::Pose pose;
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    robot.forward(rng.Uniform(0, 1), rng.Uniform(0.3, 1.2), rng.Uniform(-3, 3),
                  DrawJoints(robot, rng), pose);
    double plane = 1e9;
    double pipe = 1e9;
    double self = 1e9;
    int contacts = 0;
    for (std::size_t b = 0; b < robot.bodies.size(); ++b) {
      const Body& body = robot.bodies[b];
      const Isometry3d X_WG = pose.X_WL[body.link] * body.X_LG;
      for (const Solid& solid : scenario.solids) {
        if (solid.ground && body.group == 0) {
          continue;
        }
        const double distance = Distance(solid, body.shape, X_WG);
        (IsPipe(solid) ? pipe : plane) = std::min(IsPipe(solid) ? pipe : plane, distance);
        contacts += distance <= 0;
      }
      for (std::size_t o = b + 1; o < robot.bodies.size(); ++o) {
        const Body& other = robot.bodies[o];
        if (std::abs(body.group - other.group) >= 2) {
          const double distance =
              ConvexDistance(body.shape, X_WG, other.shape, pose.X_WL[other.link] * other.X_LG);
          self = std::min(self, distance);
          contacts += distance <= 0;
        }
      }
    }
    const Clearance measured = meter.Measure(pose.X_WL);
    ASSERT_NEAR(measured.plane.distance_m, plane, 3e-8) << i;
    ASSERT_NEAR(measured.pipe.distance_m, pipe, 3e-8) << i;
    ASSERT_NEAR(measured.self.distance_m, self, 3e-8) << i;
    ASSERT_EQ(measured.contacts, contacts) << i;
    ASSERT_EQ(meter.Touches(pose.X_WL), contacts > 0) << i;
    touching += contacts > 0;
  }
  EXPECT_GT(touching, 20);
  EXPECT_LT(touching, 290);
}

/// A ball on a link that can be put anywhere.
struct Ball {
  RobotBodies robot;
  std::vector<Isometry3d> X_WL = {Isometry3d::Identity(), Isometry3d::Identity()};

  Ball() {
    robot.links = 2;
    robot.bodies.push_back({"ball", 1, 1, Shape::Sphere(0.1), Isometry3d::Identity()});
    robot.bodies.push_back({"foot", 0, 0, Shape::Box({0.2, 0.2, 0.2}), Isometry3d::Identity()});
  }
  std::span<const Isometry3d> At(const Vector3d& p) {
    X_WL[1].translation() = p;
    return X_WL;
  }
};

TEST(ClearanceMeter, CountsAContactOnceUntilItParts) {
  Ball ball;
  std::vector<Solid> solids(1);
  solids[0].name = "post";
  solids[0].kind = SolidKind::kCylinder;
  solids[0].shape = Shape::Cylinder(0.1, 1);
  solids[0].X_WG.translation() = Vector3d(2, 0, 0);
  ClearanceMeter meter(solids, ball.robot);
  for (const double x : {1.0, 1.81, 1.85, 1.9, 1.7, 1.81, 1.0}) {
    meter.Measure(ball.At({x, 0, 0}));
  }
  EXPECT_EQ(meter.contact_episodes(), 2);
  EXPECT_EQ(meter.touched(), std::vector<std::string>{"ball - post"});
  EXPECT_EQ(meter.Measure(ball.At({0.1, 0, 0})).contacts, 1);  // the robot's own foot
  EXPECT_EQ(meter.contact_episodes(), 3);
  EXPECT_EQ(meter.touched().back(), "ball - foot");
}

TEST(ClearanceMeter, LetsTheBaseStandOnTheGroundButNotTheArm) {
  Ball ball;
  std::vector<Solid> solids(1);
  solids[0].kind = SolidKind::kPlane;
  solids[0].ground = true;  // the foot's lower half is in it
  ClearanceMeter meter(solids, ball.robot);
  EXPECT_EQ(meter.Measure(ball.At({1, 0, 0.5})).contacts, 0);
  EXPECT_NEAR(meter.Measure(ball.At({1, 0, 0.5})).plane.distance_m, 0.4, 1e-12);
  EXPECT_EQ(meter.Measure(ball.At({1, 0, 0.05})).contacts, 1);
  solids[0].ground = false;
  EXPECT_EQ(meter.Measure(ball.At({1, 0, 0.5})).contacts, 1);
}

TEST(ShippedScenarios, StartClearOfEverythingByTheOperatorsWord) {
  const RobotBodies robot = TheRobot();
  for (const ShippedToml& shipped : ShippedScenarios()) {
    const Scenario s = *LoadScenario(std::string(shipped.name)).scenario;
    ClearanceMeter meter(s.solids, robot);
    RobotBodies::Pose pose;
    robot.forward(s.start.x_m, s.start.y_m, s.start.yaw_rad, s.start.joints_rad, pose);
    const Clearance clearance = meter.Measure(pose.X_WL);
    EXPECT_GT(clearance.plane.distance_m, s.start.clearance_m) << s.name;
    EXPECT_GT(clearance.pipe.distance_m, s.start.clearance_m) << s.name;
    EXPECT_GT(clearance.self.distance_m, 0) << s.name;
  }
}

}  // namespace
}  // namespace pipewright::hil
