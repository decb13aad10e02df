// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "ctrl/whole_body/whole_body_controller.h"
#include "platform/robot/state_history.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::HomeConfiguration;
using test::MakePipe;
using test::MakePlane;
using test::RandomDirection;
using test::RandomIn;

constexpr Duration kPeriod = std::chrono::milliseconds(10);

Vec<6> SensorAt(const Configuration& q) {
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  Vec<6> x;
  x << k.p_WS(), k.z_WS();
  return x;
}

Goal GoalAt(std::uint32_t id, const Configuration& q) {
  Goal goal;
  goal.id = id;
  goal.p_WS = SensorAt(q).head<3>();
  goal.z_WS = SensorAt(q).tail<3>();
  return goal;
}

Configuration Near(Rng& rng, const Configuration& q, double base, double joints) {
  Configuration near = q;
  for (int i = 0; i < kDof; ++i) {
    near(i) += (i < 3 ? base : joints) * rng.Uniform(-1, 1);
  }
  return near;
}

/// The kinematic robot under the controller: u is what moves it.
struct Loop {
  explicit Loop(const WholeBodyConfig& config = {})
      : controller(config, TracerUf7(), TracerUf7Shapes()) {
    state.valid = true;
    state.q = HomeConfiguration();
  }
  const ControlOutput& Step() {
    output = controller.Step({state, scene, world.field(), goal, covariance_q}, now);
    state.q = Advance(state.q, output.u, ToSeconds(kPeriod));
    state.u = output.u;
    now += kPeriod;
    state.stamp = now;
    for (int j = 0; j < kArmJoints; ++j) {
      EXPECT_LE(state.q(3 + j), TracerUf7().arm.joints[j].q_max_rad);
      EXPECT_GE(state.q(3 + j), TracerUf7().arm.joints[j].q_min_rad);
    }
    return output;
  }
  GoalState Run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 100); ++i) {
      const GoalState s = Step().progress.state;
      if (s == GoalState::kReached || s == GoalState::kStalled) {
        return s;
      }
    }
    return GoalState::kMoving;
  }

  WholeBodyController controller;
  Scene scene;
  test::VoxelWorld world;
  Goal goal;
  RobotState state;
  const StateCovariance* covariance_q = nullptr;
  ControlOutput output;
  Time now{};
};

TEST(ClosedLoop, ReachesSetPointsWithThePublishedLaw) {
  Loop loop;
  for (std::uint32_t i = 1; i <= 6; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    loop.goal = GoalAt(i, Near(rng, HomeConfiguration(), 0.3, 0.5));
    // Weak directions close slowly under λ_c: the last millimetre may take a minute.
    EXPECT_NE(loop.Run(60), GoalState::kStalled);
    EXPECT_LT(loop.output.progress.error, 0.003);
  }
}

TEST(ClosedLoop, ReachesSetPointsAlongPaths) {
  Loop loop;
  for (std::uint32_t i = 1; i <= 6; ++i) {
    SCOPED_TRACE(i);
    Rng rng(2, i);
    Configuration q = loop.state.q;
    Goal goal;
    for (int k = 0; k < 3; ++k) {
      q = Near(rng, HomeConfiguration(), 0.4, 0.4);
      ASSERT_TRUE(goal.path.push_back(q));
    }
    const FixedVector<Configuration, Goal::kMaxWaypoints> path = goal.path;
    goal = GoalAt(i, q);
    goal.path = path;
    loop.goal = goal;
    EXPECT_EQ(loop.Run(60), GoalState::kReached);
    // It came the planned way: its posture is the path's last, not just any with that sensor pose.
    EXPECT_LT((loop.state.q - q).tail<kArmJoints>().cwiseAbs().maxCoeff(), 0.1);
  }
}

TEST(ClosedLoop, KeepsEveryDistanceInRandomWorlds) {
  int near_plane = 0;
  int near_voxel = 0;
  for (int i = 0; i < 8; ++i) {
    SCOPED_TRACE(i);
    Rng rng(3, i);
    WholeBodyConfig config;
    config.constraints.price[static_cast<int>(RowKind::kPipe)] = 0;  // hard, so that it must hold
    Loop loop(config);
    const Vector3d center{0.3, 0, 0.6};
    for (std::uint32_t k = 1; k <= 4; ++k) {
      const Vector3d n = RandomDirection(rng);
      (void)loop.scene.planes.push_back(MakePlane(k, center - 0.55 * n, n, 5, 0, 0));
    }
    const Vector3d off = RandomDirection(rng);
    (void)loop.scene.pipes.push_back(
        MakePipe(9, center + 0.75 * off, off.unitOrthogonal(), 0.05, 1, 0, 0));
    for (int k = 0; k < 40; ++k) {
      loop.world.AddObstacle(center + rng.Uniform(0.75, 1.0) * RandomDirection(rng));
    }
    loop.world.Update();
    Clearances start;
    for (std::uint32_t g = 1; g <= 3; ++g) {
      loop.goal = GoalAt(g, Near(rng, HomeConfiguration(), 0.2, 0.6));
      loop.goal.p_WS = center + rng.Uniform(0.3, 1.2) * RandomDirection(rng);
      for (int step = 0; step < 500; ++step) {
        const ControlOutput& out = loop.Step();
        EXPECT_NE(out.stats.qp.status, QpStatus::kInfeasible);
        const Clearances& now = out.stats.clearance;
        if (g == 1 && step == 0) {
          start = now;
        }
        // Spheres differ in d_safe - r: the least of it is what all of them keep.
        constexpr double kHeld_m = 0.002;    // what a held u may take where it slides along
        constexpr double kCorner_m = 0.006;  // and where another voxel becomes the nearest
        EXPECT_GE(now.plane_m, std::min(start.plane_m, 0.025) - kHeld_m);
        EXPECT_GE(now.pipe_m, std::min(start.pipe_m, 0.025) - kHeld_m);
        EXPECT_GE(now.self_m, std::min(start.self_m, 0.02) - kHeld_m);
        EXPECT_GE(now.obstacle_m, std::min(start.obstacle_m, 0.02) - kCorner_m);
        near_plane += now.plane_m < 0.1 ? 1 : 0;
        near_voxel += now.obstacle_m < 0.1 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(near_plane, 1000);  // the worlds do stand in the way
  EXPECT_GT(near_voxel, 1000);
}

TEST(ClosedLoop, AGoalBehindAWallStalls) {
  Loop loop;
  const Vector3d p = SensorAt(HomeConfiguration()).head<3>();
  (void)loop.scene.planes.push_back(
      MakePlane(1, p + Vector3d(0.3, 0, 0), {-1, 0, 0}, 5, 0.001, 0.001));
  loop.goal = GoalAt(1, HomeConfiguration());
  loop.goal.p_WS += Vector3d(0.6, 0, 0);
  EXPECT_EQ(loop.Run(60), GoalState::kStalled);
  EXPECT_GT(loop.output.stats.clearance.plane_m, 0.02);
  EXPECT_EQ(loop.output.stats.qp.held, loop.output.stats.qp.checked);
  // A new goal starts the watch again.
  loop.goal = GoalAt(2, HomeConfiguration());
  EXPECT_EQ(loop.Step().progress.state, GoalState::kMoving);
  EXPECT_EQ(loop.Run(60), GoalState::kReached);
}

/// Along the axis no direction across it leads away: the end itself must stop the robot.
TEST(ClosedLoop, AGoalWithinAPipeIsNotReachedThroughItsEnd) {
  WholeBodyConfig config;
  config.constraints.price[static_cast<int>(RowKind::kPipe)] = 0;  // hard, so that it must hold
  Loop loop(config);
  const Vector3d p = SensorAt(HomeConfiguration()).head<3>();
  constexpr double kInflation_m = ConstraintConfig{}.pipe_inflation_m;
  const Vector3d end = p + Vector3d(0.5 + kInflation_m, 0, 0);
  (void)loop.scene.pipes.push_back(
      MakePipe(1, end + Vector3d(0.5, 0, 0), {1, 0, 0}, 0.05, 0.5, 0, 0));
  loop.goal = GoalAt(1, HomeConfiguration());
  loop.goal.p_WS = end + Vector3d(0.2, 0, 0);
  double least_m = 1e9;
  for (int i = 0; i < 2000; ++i) {
    const ControlOutput& out = loop.Step();
    EXPECT_NE(out.stats.qp.status, QpStatus::kInfeasible);
    least_m = std::min(least_m, out.stats.clearance.pipe_m);
  }
  EXPECT_GT(least_m, ConstraintConfig{}.margin_m - 0.002);
  EXPECT_LT(least_m, 0.06);  // it was pressed against the end
}

TEST(ClosedLoop, ARobotThatIsLessSureOfItselfKeepsMoreDistance) {
  constexpr double kSigma_m = 0.02;
  StateCovariance covariance;
  covariance.base(0, 0) = kSigma_m * kSigma_m;
  double kept_m[2];
  for (int unsure = 0; unsure < 2; ++unsure) {
    WholeBodyConfig config;
    config.constraints.alpha = 0.95;
    Loop loop(config);
    loop.covariance_q = unsure == 1 ? &covariance : nullptr;
    const Vector3d p = SensorAt(HomeConfiguration()).head<3>();
    (void)loop.scene.planes.push_back(MakePlane(1, p + Vector3d(0.4, 0, 0), {-1, 0, 0}, 5, 0, 0));
    loop.goal = GoalAt(1, HomeConfiguration());
    loop.goal.p_WS += Vector3d(0.6, 0, 0);
    EXPECT_EQ(loop.Run(60), GoalState::kStalled);
    kept_m[unsure] = loop.output.stats.clearance.plane_m;
  }
  // Standing before the wall, x is all that counts: 1.645 σ more.
  EXPECT_NEAR(kept_m[1] - kept_m[0], 1.645 * kSigma_m, 0.003);
}

TEST(ClosedLoop, AnEstimateThatTurnsOutNearerIsLeftSlowly) {
  Loop loop;
  const Vector3d p = SensorAt(HomeConfiguration()).head<3>();
  loop.goal = GoalAt(1, HomeConfiguration());
  loop.Run(5);
  (void)loop.scene.planes.push_back(MakePlane(1, p + Vector3d(0.08, 0, 0), {-1, 0, 0}, 5, 0, 0));
  const double before = loop.Step().stats.clearance.plane_m;
  loop.goal.id = 2;
  for (int i = 0; i < 500; ++i) {
    const double was = loop.output.stats.clearance.plane_m;
    loop.Step();
    EXPECT_GE(loop.output.stats.clearance.plane_m, was - 1e-4);
    EXPECT_LE(loop.output.stats.clearance.plane_m, was + 0.0008);  // 5 cm/s and a little
  }
  EXPECT_GT(loop.output.stats.clearance.plane_m, before + 0.01);
}

TEST(WholeBodyController, StandsStillWithoutGoalOrStateOrConfiguration) {
  Loop loop;
  EXPECT_TRUE(loop.Step().u.isZero(0));
  EXPECT_EQ(loop.output.progress.state, GoalState::kNone);
  loop.goal = GoalAt(1, HomeConfiguration());
  loop.goal.p_WS.x() += 0.2;
  EXPECT_FALSE(loop.Step().u.isZero(0));
  loop.state.valid = false;
  EXPECT_TRUE(loop.Step().u.isZero(0));
  loop.state.valid = true;
  loop.state.emergency_stop = true;
  EXPECT_TRUE(loop.Step().u.isZero(0));
  loop.state.emergency_stop = false;
  loop.state.q(4) = std::nan("");
  EXPECT_TRUE(
      loop.controller.Step({loop.state, loop.scene, loop.world.field(), loop.goal}, loop.now)
          .u.isZero(0));

  WholeBodyConfig config;
  config.constraints.alpha = 0.4;
  Loop refused(config);
  EXPECT_EQ(refused.controller.status(), Status::kOutOfRange);
  refused.goal = loop.goal;
  EXPECT_TRUE(refused.Step().u.isZero(0));
}

TEST(WholeBodyController, StandsStillUntilTheMapIsThere) {
  Loop loop;
  loop.goal = GoalAt(1, HomeConfiguration());
  loop.goal.p_WS.x() += 0.2;
  const DistanceField nothing;
  EXPECT_TRUE(
      loop.controller.Step({loop.state, loop.scene, nothing, loop.goal}, loop.now).u.isZero(0));
}

TEST(WholeBodyController, SameInputsGiveSameOutputs) {
  Loop a;
  Loop b;
  for (Loop* loop : {&a, &b}) {
    Rng rng(5);
    loop->goal = GoalAt(1, Near(rng, HomeConfiguration(), 0.3, 0.5));
    (void)loop->scene.planes.push_back(MakePlane(1, {0, 0, 0}, {0, 0, 1}, 2, 0.01, 0.01));
    loop->Run(3);
  }
  EXPECT_EQ(a.state.q, b.state.q);
}

}  // namespace
}  // namespace pipewright
