// SPDX-License-Identifier: MIT
// The controller's model against Orocos KDL on the plant's URDF: written apart, they must agree.
#include <gtest/gtest.h>

#include "hil/plant/plant.h"
#include "platform/core/rng.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/robot.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

constexpr double kTolerance = 1e-9;

ArmVector RandomJoints(Rng& rng) {
  const ArmVector lo = JointValues(TracerUf7(), &ArmJoint::q_min_rad);
  const ArmVector hi = JointValues(TracerUf7(), &ArmJoint::q_max_rad);
  ArmVector joints;
  for (int i = 0; i < kArmJoints; ++i) {
    joints(i) = rng.Uniform(lo(i), hi(i));
  }
  return joints;
}

TEST(PlantAgreement, EveryFrameIsWhereKdlPutsIt) {
  const char* const kLinks[] = {"base_link", "link1", "link2", "link3", "link4",
                                "link5",     "link6", "link7", "tool"};
  const hil::RobotDescription description = hil::TracerUf7Description();
  Rng rng(21);
  for (int trial = 0; trial < 100; ++trial) {
    Configuration q;
    q << rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-4, 4), RandomJoints(rng);
    const hil::Plant plant(description, {q(0), q(1), q(2)}, q.tail<kArmJoints>());
    const Kinematics<kArmJoints> body(TracerUf7(), q);
    for (int b = 0; b < Kinematics<kArmJoints>::kBodies; ++b) {
      SCOPED_TRACE(kLinks[b]);
      const Isometry3d& X_WL = plant.X_WL(plant.LinkIndex(kLinks[b]));
      EXPECT_LT((X_WL.matrix() - body.X_WL(b).matrix()).cwiseAbs().maxCoeff(), kTolerance);
    }
    EXPECT_LT((plant.X_WS().matrix() - body.X_WS().matrix()).cwiseAbs().maxCoeff(), kTolerance);
    EXPECT_LT((plant.p_WP() - body.p_WP()).cwiseAbs().maxCoeff(), kTolerance);
  }
}

TEST(PlantAgreement, JointLimitsAreTheSame) {
  const hil::Plant plant(hil::TracerUf7Description(), {}, HomeJoints(TracerUf7()));
  EXPECT_EQ(plant.lower_rad(), JointValues(TracerUf7(), &ArmJoint::q_min_rad));
  EXPECT_EQ(plant.upper_rad(), JointValues(TracerUf7(), &ArmJoint::q_max_rad));
}

TEST(PlantAgreement, AStepOfThePlantIsWhatTheJacobianSays) {
  constexpr Duration kDt = std::chrono::microseconds(10);
  const hil::RobotDescription description = hil::TracerUf7Description();
  Rng rng(22);
  for (int trial = 0; trial < 20; ++trial) {
    Configuration q;
    q << 0.3, -0.2, rng.Uniform(-3, 3), 0.5 * RandomJoints(rng);
    Controls u;
    for (int i = 0; i < kControls; ++i) {
      u(i) = rng.Uniform(-1, 1);
    }
    hil::Plant plant(description, {q(0), q(1), q(2)}, q.tail<kArmJoints>());
    plant.Step(kDt, u(0), u(1), u.tail<kArmJoints>());
    const Kinematics<kArmJoints> body(TracerUf7(), q);
    const Vector3d v = (plant.X_WS().translation() - body.p_WS()) / ToSeconds(kDt);
    EXPECT_LT((v - body.SensorJacobian().topRows<3>() * u).norm(), 1e-4);  // first order in 1e-5 s
  }
}

}  // namespace
}  // namespace pipewright
