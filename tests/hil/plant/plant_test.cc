// SPDX-License-Identifier: MIT
#include "hil/plant/plant.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

using std::chrono::milliseconds;
using Joints = Vec<kPlantJoints>;

/// The vendor's modified DH table, A_i = Rx(alpha) Tx(a) Rz(theta) Tz(d): an oracle apart from URDF
/// and KDL.
Isometry3d DhLink(int links, const Joints& q) {
  struct Row {
    double d, alpha, a;
  };
  const Row rows[] = {{.267, 0, 0},           {0, -M_PI / 2, 0},        {.293, M_PI / 2, 0},
                      {0, M_PI / 2, .0525},   {.3425, M_PI / 2, .0775}, {0, M_PI / 2, 0},
                      {.097, -M_PI / 2, .076}};
  Isometry3d X = Isometry3d::Identity();
  for (int i = 0; i < links; ++i) {
    X = X * Eigen::AngleAxisd(rows[i].alpha, Vector3d::UnitX()) *
        Eigen::Translation3d(rows[i].a, 0, 0) * Eigen::AngleAxisd(q(i), Vector3d::UnitZ()) *
        Eigen::Translation3d(0, 0, rows[i].d);
  }
  return X;
}

Plant At(const BasePose& base, const Joints& joints) {
  return Plant(TracerUf7Description(), base, joints);
}

TEST(Plant, AtZeroTheFlangeIsWhereTheVendorSaysItIs) {
  const Plant plant = At({}, Joints::Zero());
  const Isometry3d X_AF =
      plant.X_WL(plant.LinkIndex("arm_base")).inverse() * plant.X_WL(plant.LinkIndex("link7"));
  EXPECT_NEAR((X_AF.translation() - Vector3d(0.206, 0, 0.1205)).norm(), 0, 1e-12);
}

TEST(Plant, EveryLinkIsTheDhFrameOfItsJoint) {
  Rng rng(11);
  for (int trial = 0; trial < 50; ++trial) {
    const BasePose base{rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-3, 3)};
    Joints q;
    const Plant reference = At({}, Joints::Zero());
    for (int i = 0; i < kPlantJoints; ++i) {
      q(i) = rng.Uniform(reference.lower_rad()(i), reference.upper_rad()(i));
    }
    const Plant plant = At(base, q);
    const Isometry3d X_WA = Eigen::Translation3d(base.x_m, base.y_m, 0) *
                            Eigen::AngleAxisd(base.yaw_rad, Vector3d::UnitZ()) *
                            Eigen::Translation3d(0.10, 0, 0.28);
    for (int i = 1; i <= kPlantJoints; ++i) {
      const Isometry3d X_WL = X_WA * DhLink(i, q);
      const int link = plant.LinkIndex("link" + std::to_string(i));
      EXPECT_LT((plant.X_WL(link).matrix() - X_WL.matrix()).norm(), 1e-13) << "link " << i;
    }
    const Isometry3d X_WF = X_WA * DhLink(7, q);
    EXPECT_LT((plant.X_WS().translation() - X_WF * Vector3d(0, 0, 0.045)).norm(), 1e-13);
    EXPECT_LT((plant.X_WS().linear() - X_WF.linear()).norm(), 1e-13);
    EXPECT_LT((plant.p_WP() - X_WF * Vector3d(0, 0.045, 0.050)).norm(), 1e-13);
  }
}

TEST(Plant, TheBaseDrivesTheCirclesArc) {
  struct Case {
    const char* name;
    double v, omega;
  };
  for (const Case& c :
       {Case{"straight", 0.3, 0}, Case{"nearly straight", 0.3, 1e-9}, Case{"left", 0.3, 0.7},
        Case{"back right", -0.2, -1.1}, Case{"on the spot", 0, 2}}) {
    SCOPED_TRACE(c.name);
    Plant plant = At({1, 2, 0.5}, Joints::Zero());
    plant.Step(milliseconds(1500), c.v, c.omega, Joints::Zero());
    double x = 1;  // midpoint rule: its error at these steps is under 1e-9
    double y = 2;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
      const double yaw = 0.5 + c.omega * 1.5 * (i + 0.5) / n;
      x += c.v * 1.5 / n * std::cos(yaw);
      y += c.v * 1.5 / n * std::sin(yaw);
    }
    EXPECT_NEAR(plant.base().x_m, x, 1e-9);
    EXPECT_NEAR(plant.base().y_m, y, 1e-9);
    EXPECT_NEAR(plant.base().yaw_rad, 0.5 + c.omega * 1.5, 1e-14);
    const Isometry3d X_WB = plant.X_WB();
    EXPECT_EQ(X_WB.matrix(), plant.X_WL(0).matrix());
    EXPECT_EQ(X_WB.translation().z(), 0);
  }
}

TEST(Plant, ManySmallStepsEqualOneLongOne) {
  Plant one = At({}, Joints::Zero());
  Plant many = At({}, Joints::Zero());
  const Joints qdot = Joints::LinSpaced(-0.3, 0.4);
  one.Step(milliseconds(400), 0.4, -0.8, qdot);
  for (int i = 0; i < 400; ++i) {
    many.Step(milliseconds(1), 0.4, -0.8, qdot);
  }
  EXPECT_NEAR(one.base().x_m, many.base().x_m, 1e-13);
  EXPECT_NEAR(one.base().y_m, many.base().y_m, 1e-13);
  EXPECT_LT((one.joints_rad() - many.joints_rad()).norm(), 1e-13);
  EXPECT_LT((one.X_WS().matrix() - many.X_WS().matrix()).norm(), 1e-12);
}

TEST(Plant, AJointStopsHardAtItsLimitAndTheTouchIsCountedOnce) {
  Plant plant = At({}, Joints::Zero());
  Joints qdot = Joints::Zero();
  qdot(3) = -1.0;
  for (int i = 0; i < 300; ++i) {
    plant.Step(milliseconds(1), 0, 0, qdot);
  }
  EXPECT_EQ(plant.joints_rad()(3), plant.lower_rad()(3));
  EXPECT_EQ(plant.hard_stops(3), 1);
  qdot(3) = 1.0;
  plant.Step(milliseconds(10), 0, 0, qdot);
  EXPECT_GT(plant.joints_rad()(3), plant.lower_rad()(3));
  qdot(3) = -1.0;
  plant.Step(milliseconds(20), 0, 0, qdot);
  EXPECT_EQ(plant.hard_stops(3), 2);
  EXPECT_EQ(plant.hard_stops(), 2);
}

TEST(Plant, AStartOutsideTheLimitsIsPutOnThem) {
  const Plant plant = At({}, Joints::Constant(9));
  EXPECT_EQ(plant.joints_rad(), plant.upper_rad());
  EXPECT_EQ(plant.hard_stops(), 0);
}

TEST(Plant, NonFiniteVelocitiesDoNotMoveIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  Plant plant = At({1, 2, 3}, Joints::Zero());
  plant.Step(milliseconds(1), nan, inf, Joints::Constant(nan));
  EXPECT_EQ(plant.base().x_m, 1);
  EXPECT_EQ(plant.base().yaw_rad, 3);
  EXPECT_EQ(plant.joints_rad(), Joints::Zero());
}

}  // namespace
}  // namespace pipewright::hil
