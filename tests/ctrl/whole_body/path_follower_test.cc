// SPDX-License-Identifier: MIT
#include "ctrl/whole_body/path_follower.h"

#include <gtest/gtest.h>

#include "platform/robot/state_history.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

constexpr double kPeriod_s = 0.01;

PathFollower::Path RandomPath(Rng& rng, Configuration q) {
  PathFollower::Path path;
  const int count = 1 + rng.Index(6);
  for (int i = 0; i < count; ++i) {
    if (rng.Uniform() < 0.7) {
      q(0) += rng.Uniform(-0.5, 0.5);
      q(1) += rng.Uniform(-0.5, 0.5);
      q(2) += rng.Uniform(-2, 2);
    }
    for (int j = 3; j < kDof && i % 2 == 0; ++j) {
      q(j) += rng.Uniform(-0.5, 0.5);
    }
    EXPECT_TRUE(path.push_back(q));
  }
  return path;
}

Controls Limits(double ArmJoint::*joint, double base, double turn, double fraction) {
  Controls limits;
  limits << base, turn, JointValues(TracerUf7(), joint);
  return fraction * limits;
}

TEST(PathFollower, ReachesTheEndOfRandomPathsWithinItsSpeeds) {
  const FollowerConfig config;
  const TracerModel& base = TracerUf7().base;
  const Controls speed =
      Limits(&ArmJoint::speed_radps, base.speed_mps, base.turn_radps, config.speed_fraction);
  const Controls acceleration = Limits(&ArmJoint::acceleration_max_radps2, base.acceleration_mps2,
                                       base.turn_acceleration_radps2, config.acceleration_fraction);
  for (int i = 0; i < 100; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    PathFollower follower(config, TracerUf7(), kPeriod_s);
    Configuration q = test::HomeConfiguration();
    const PathFollower::Path path = RandomPath(rng, q);
    if (i % 3 == 0) {
      q(0) += 0.02;  // not quite where the path starts
      q(2) += 0.05;
    }
    follower.Start(q, path);
    double way = follower.way();
    Controls last = Controls::Zero();
    int steps = 0;
    int after = 0;
    for (; steps < 30000 && after < 400; ++steps) {
      const PathFollower::Reference reference = follower.Step(q);
      EXPECT_TRUE((reference.u.cwiseAbs().array() <= speed.array() * (1 + 1e-9)).all());
      const Controls faster = reference.u.cwiseAbs() - last.cwiseAbs();
      EXPECT_TRUE((faster.array() <= kPeriod_s * acceleration.array() * (1 + 1e-6) + 1e-9).all());
      last = reference.u;
      EXPECT_GE(follower.way(), way);
      way = follower.way();
      q = Advance(q, reference.u_n.cwiseMin(1.2 * speed).cwiseMax(-1.2 * speed), kPeriod_s);
      after += follower.at_end() ? 1 : 0;
    }
    EXPECT_TRUE(follower.at_end());
    const Configuration& end = path.back();
    EXPECT_LT((q - end).head<2>().norm(), 0.03);
    EXPECT_LT(std::abs(WrapAngle(q(2) - end(2))), 0.01);
    EXPECT_LT((q - end).tail<kArmJoints>().cwiseAbs().maxCoeff(), 0.01);
  }
}

TEST(PathFollower, WaitsForARobotThatDoesNotMove) {
  PathFollower follower({}, TracerUf7(), kPeriod_s);
  const Configuration q = test::HomeConfiguration();
  Configuration far = q;
  far(0) += 1;
  PathFollower::Path path;
  ASSERT_TRUE(path.push_back(far));
  follower.Start(q, path);
  PathFollower::Reference reference;
  for (int i = 0; i < 3000; ++i) {
    reference = follower.Step(q);
  }
  EXPECT_FALSE(follower.at_end());
  EXPECT_LE(reference.q(0) - q(0), FollowerConfig{}.lag_stop);
  EXPECT_LT(reference.u.cwiseAbs().maxCoeff(), 0.01);
}

TEST(PathFollower, APathOfOnePointThatIsHereIsDoneAtOnce) {
  PathFollower follower({}, TracerUf7(), kPeriod_s);
  PathFollower::Path path;
  ASSERT_TRUE(path.push_back(test::HomeConfiguration()));
  follower.Start(path[0], path);
  const PathFollower::Reference reference = follower.Step(path[0]);
  EXPECT_TRUE(follower.at_end());
  EXPECT_TRUE(reference.u_n.isZero(1e-12));
}

}  // namespace
}  // namespace pipewright
