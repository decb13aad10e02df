// SPDX-License-Identifier: MIT
#include "plan/motion/inverse_kinematics.h"

#include <gtest/gtest.h>

#include "tests/plan/motion/cell.h"

namespace pipewright {
namespace {

SensorTarget TargetOf(const Configuration& q) {
  const Kinematics<kArmJoints> body(TracerUf7(), q);
  return {body.p_WS(), body.z_WS()};
}

Configuration NearHome(Rng& rng) {
  Configuration q = test::Cell::Start();
  for (int i = 0; i < kArmJoints; ++i) {
    q(3 + i) += rng.Uniform(-0.9, 0.9);
  }
  q(6) = std::max(q(6), -0.1);  // home is near the elbow's limit
  return q;
}

void ExpectReached(const SensorTarget& target, const Configuration& q, const ReachConfig& config) {
  const SensorTarget reached = TargetOf(q);
  EXPECT_LE((reached.p_WS - target.p_WS).norm(), config.position_m);
  EXPECT_LE((reached.z_WS - target.z_WS).norm(), config.axis);
}

void ExpectWithinLimits(const Configuration& q) {
  for (int i = 0; i < kArmJoints; ++i) {
    EXPECT_GT(q(3 + i), TracerUf7().arm.joints[i].q_min_rad);
    EXPECT_LT(q(3 + i), TracerUf7().arm.joints[i].q_max_rad);
  }
}

TEST(SolveSensor, FindsWhatForwardKinematicsMade) {
  Rng rng(61);
  int solved = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const ReachConfig config{.hold_base = trial % 2 == 0};
    const SensorTarget target = TargetOf(NearHome(rng));
    const auto q = SolveSensor(target, test::Cell::Start(), config);
    if (q) {
      ++solved;
      ExpectReached(target, *q, config);
      ExpectWithinLimits(*q);
      if (config.hold_base) {
        EXPECT_EQ(q->head<3>(), test::Cell::Start().head<3>());
      }
    }
  }
  EXPECT_GE(solved, kTrials * 9 / 10) << "a descent may end at a limit, but rarely";
}

TEST(SolveSensor, TurnsAboutWhenTheAxisIsOpposite) {
  const SensorTarget now = TargetOf(test::Cell::Start());
  const SensorTarget behind{now.p_WS, -now.z_WS};
  const auto q = SolveSensor(behind, test::Cell::Start());
  ASSERT_TRUE(q);
  ExpectReached(behind, *q, {});
}

TEST(SolveSensor, HasNoAnswerForWhatIsFarOrNotFinite) {
  const SensorTarget far{{10, 0, 1}, Vector3d::UnitX()};
  EXPECT_FALSE(SolveSensor(far, test::Cell::Start(), {.hold_base = true}));
  const SensorTarget high{{0.5, 0.7, 5}, Vector3d::UnitX()};
  EXPECT_FALSE(SolveSensor(high, test::Cell::Start()));
  SensorTarget nan = TargetOf(test::Cell::Start());
  nan.p_WS.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(SolveSensor(nan, test::Cell::Start()));
}

TEST(Unwound, IsTheSamePostureNearTheReference) {
  Rng rng(65);
  for (int trial = 0; trial < 100; ++trial) {
    Configuration q = NearHome(rng);
    Configuration reference = NearHome(rng);
    for (const int turning : {3, 5, 7, 9}) {
      q(turning) = rng.Uniform(-6, 6);
      reference(turning) = rng.Uniform(-3, 3);
    }
    const Configuration unwound = Unwound(q, reference);
    const Kinematics<kArmJoints> before(TracerUf7(), q);
    const Kinematics<kArmJoints> after(TracerUf7(), unwound);
    EXPECT_LT((before.X_WS().matrix() - after.X_WS().matrix()).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LE((unwound - reference).tail<kArmJoints>().cwiseAbs().maxCoeff(), 3.1416);
    ExpectWithinLimits(unwound);
  }
  Configuration wound = Configuration::Zero();
  Configuration reference = Configuration::Zero();
  wound(3) = -6;
  reference(3) = 6.25;
  EXPECT_EQ(Unwound(wound, reference), wound) << "the nearer turn is beyond the joint's limit";
}

TEST(Reach, WhatItGivesIsFreeAndThere) {
  test::Cell cell;
  cell.AddThreePipes();
  const CollisionChecker checker(cell.around());
  Rng rng(62);
  int reached = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Configuration made = NearHome(rng);
    if (!checker.Free(made)) {
      continue;
    }
    const SensorTarget target = TargetOf(made);
    const auto q = Reach(checker, target, test::Cell::Start(), rng);
    if (q) {
      ++reached;
      ExpectReached(target, *q, {});
      EXPECT_TRUE(checker.Free(*q));
    }
  }
  EXPECT_GT(reached, kTrials / 3);
}

TEST(Reach, NothingInsideAPipe) {
  test::Cell cell;
  cell.AddThreePipes();
  const CollisionChecker checker(cell.around());
  Rng rng(63);
  const SensorTarget inside{{1.25, 1.2, 0.7}, Vector3d::UnitX()};
  EXPECT_FALSE(Reach(checker, inside, test::Cell::Start(), rng));
}

TEST(Reach, TheSameSeedGivesTheSameAnswer) {
  test::Cell cell;
  cell.AddThreePipes();
  const CollisionChecker checker(cell.around());
  const SensorTarget target{{0.9, 0.5, 0.8}, Vector3d{1, -0.5, 0}.normalized()};
  Rng a(64);
  Rng b(64);
  const auto first = Reach(checker, target, test::Cell::Start(), a);
  const auto second = Reach(checker, target, test::Cell::Start(), b);
  ASSERT_EQ(first.has_value(), second.has_value());
  if (first) {
    EXPECT_EQ(*first, *second);
  }
}

}  // namespace
}  // namespace pipewright
