// SPDX-License-Identifier: MIT
// What `exact` promises is of the u that is sent: the envelope's answer. Two things are no part of
// it. The drivers round u to the bits of their frames (1 mm/s and 1 mrad/s of the base, 1e-6 rad/s
// of a joint). And where no u that the robot can brake to keeps every row, the law says so and how
// to brake: such a cycle's rows are counted as they hold for what is sent.
#include <gtest/gtest.h>

#include <map>

#include "ctrl/robot_program/control_task.h"
#include "platform/robot/state_history.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::RandomDirection;

constexpr double kTolerance_mps = 1e-6;
constexpr Duration kPeriod = std::chrono::milliseconds(10);

/// Planes, pipes, a pipe that points at the robot and voxels, all about the place that the goals
/// are beyond.
struct World {
  explicit World(Rng& rng) {
    const Vector3d center{0.35, 0, 0.65};
    for (std::uint32_t k = 1; k <= 2; ++k) {
      const Vector3d n = RandomDirection(rng);
      EXPECT_TRUE(scene.planes.push_back(
          test::MakePlane(k, center - rng.Uniform(0.5, 0.7) * n, n, 2, 0.02, 0.008)));
      const Vector3d off = RandomDirection(rng);
      EXPECT_TRUE(
          scene.pipes.push_back(test::MakePipe(k + 2, center + rng.Uniform(0.5, 0.7) * off,
                                               off.unitOrthogonal(), 0.05, 1, 0.005, 0.02)));
    }
    const Vector3d ahead = RandomDirection(rng);
    EXPECT_TRUE(scene.pipes.push_back(
        test::MakePipe(9, center + 0.9 * ahead, ahead, 0.08, 0.35, 0.005, 0.02)));
    for (int k = 0; k < 40; ++k) {
      voxels.AddObstacle(center + rng.Uniform(0.55, 0.9) * RandomDirection(rng));
    }
    voxels.Update();
  }
  Scene scene;
  test::VoxelWorld voxels;
};

TEST(Sent, ExactKeepsEveryConeAtTheControlsThatTheEnvelopeLetsThrough) {
  ControlTaskConfig config;
  config.law.constraints.price[static_cast<int>(RowKind::kPipe)] =
      0;  // a soft row promises nothing
  StateCovariance covariance;
  covariance.base.diagonal() << 1e-5, 1e-5, 1e-5;
  covariance.joint_rad2.setConstant(1e-6);
  std::map<RowKind, int> active;
  int ends_active = 0;
  int cycles = 0;
  int out_of_reach = 0;
  int rounds_most = 0;
  for (int i = 0; i < 24; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    config.law.constraints.alpha = rng.Uniform(0.5, 0.999);
    WholeBodyController law(config.law, TracerUf7(), TracerUf7Shapes());
    Envelope envelope(EnvelopeOf(TracerUf7(), config));
    const World world(rng);
    RobotState state;
    state.valid = true;
    state.q = test::HomeConfiguration();
    for (int j = 0; j < kDof; ++j) {
      state.q(j) += rng.Uniform(-0.2, 0.2);
    }
    Goal goal;
    Time now{};
    for (int cycle = 0; cycle < 400; ++cycle) {
      if (cycle % 100 == 0) {
        ++goal.id;
        Configuration to = state.q;
        for (int j = 0; j < kDof; ++j) {
          to(j) += (j < 3 ? 0.4 : 0.8) * rng.Uniform(-1, 1);
        }
        const Kinematics<kArmJoints> k(TracerUf7(), to);
        goal.p_WS = k.p_WS();
        goal.z_WS = k.z_WS();
        goal.path.clear();
        EXPECT_TRUE(goal.path.push_back(state.q) && goal.path.push_back(to));
      }
      ControlOutput out =
          law.Step({state, world.scene, world.voxels.field(), goal, &covariance}, now);
      const Controls sent = envelope.Step(out.u, state, now).u;
      law.Sent(sent, out.stats);
      ++cycles;
      rounds_most = std::max(rounds_most, out.stats.qp.rounds);
      const bool reached = !out.stats.qp.out_of_reach;
      out_of_reach += reached ? 0 : 1;
      if (reached) {
        ASSERT_LT((sent - out.u).cwiseAbs().maxCoeff(), 1e-9);
      }
      int held = 0;
      for (const ChanceRow& row : law.constraints().chance) {
        const double excess = ChanceExcess(row, sent, law.constraints().z);
        held += excess + row.limit <= row.b + kTolerance_mps ? 1 : 0;
        if (reached) {
          ASSERT_LE(excess, kTolerance_mps);
          const bool leaned_on = excess > -1e-5;
          active[static_cast<RowKind>(row.key >> 26)] += leaned_on ? 1 : 0;
          ends_active += leaned_on && (row.key & 0xFFFF) == 9 ? 1 : 0;
        }
      }
      EXPECT_EQ(out.stats.qp.held, held);
      EXPECT_EQ(out.stats.qp.checked, law.constraints().chance.size());
      state.q = Advance(state.q, sent, ToSeconds(kPeriod));
      state.u = sent;
      now += kPeriod;
      state.stamp = now;
    }
  }
  EXPECT_LE(rounds_most, config.law.svfi_rounds + 1);  // and one for the worst case
  EXPECT_LT(out_of_reach, cycles / 10);
  EXPECT_GT(active[RowKind::kPlane], 300);
  EXPECT_GT(active[RowKind::kPipe], 500);
  EXPECT_GT(active[RowKind::kVoxel], 500);
  EXPECT_GT(active[RowKind::kColumn], 500);
  EXPECT_GT(ends_active, 300);
}

}  // namespace
}  // namespace pipewright
