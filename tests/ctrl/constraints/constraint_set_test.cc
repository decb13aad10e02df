// SPDX-License-Identifier: MIT
#include "ctrl/constraints/constraint_set.h"

#include <gtest/gtest.h>

#include "ctrl/constraints/row_maker.h"
#include "platform/robot/state_history.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::MakePipe;
using test::MakePlane;
using test::RandomConfiguration;
using test::RandomDirection;
using test::RandomIn;

const Vector3d kLo{-0.9, -0.9, 0};
const Vector3d kHi{0.9, 0.9, 1.4};

void Build(const ConstraintConfig& config, const Configuration& q, const Controls& u_sent,
           const Scene& scene, const DistanceField& field, ConstraintSet& set) {
  const ConstraintBuilder builder(config, TracerUf7(), TracerUf7Shapes());
  builder.Build(q, Kinematics<kArmJoints>(TracerUf7(), q), u_sent, scene, field, set);
}

Scene RandomScene(Rng& rng) {
  Scene scene;
  for (std::uint32_t i = 0; i < 6; ++i) {
    EXPECT_TRUE(scene.planes.push_back(MakePlane(i + 1, RandomIn(rng, kLo, kHi),
                                                 RandomDirection(rng), rng.Uniform(0.1, 1),
                                                 rng.Uniform(0, 0.02), rng.Uniform(0, 0.02))));
    EXPECT_TRUE(scene.pipes.push_back(MakePipe(i + 1, RandomIn(rng, kLo, kHi), RandomDirection(rng),
                                               0.06, 0.7, rng.Uniform(0, 0.02), 0.01)));
  }
  return scene;
}

Controls RandomControls(Rng& rng) {
  Controls u;
  for (int i = 0; i < kControls; ++i) {
    u(i) = rng.Uniform(-0.4, 0.4);
  }
  return u;
}

/// The invariant everything rests on, wherever the robot is and whatever the estimates say.
TEST(ConstraintBuilder, StandingStillKeepsEveryHardRowAndTheBox) {
  int clamped = 0;
  int dropped = 0;
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    test::VoxelWorld world;
    for (int k = 0; k < 30; ++k) {
      world.AddObstacle(RandomIn(rng, kLo, kHi));
    }
    world.Update();
    ConstraintConfig config;
    config.alpha = rng.Uniform(0.5, 0.999);
    if (i % 2 == 1) {
      config.price = {0, 0, 0, 0, 0, 0, 0, 5e3};  // all hard
    }
    Configuration q = RandomConfiguration(rng);
    if (i % 3 == 0) {
      q(4) = 2.2;  // past joint 2's limit
    }
    const Controls u_sent = RandomControls(rng);
    static ConstraintSet set;
    Build(config, q, u_sent, RandomScene(rng), world.field(), set);
    EXPECT_LE(set.lb.maxCoeff(), 0);
    EXPECT_GE(set.ub.minCoeff(), 0);
    for (const Row& row : set.rows) {
      EXPECT_TRUE(row.a.allFinite());
      if (row.price == 0) {
        EXPECT_LE(row.lo, 0);
        EXPECT_GE(row.hi, 0) << static_cast<int>(KindOf(row));
      }
    }
    for (const ChanceRow& row : set.chance) {
      EXPECT_TRUE(row.a.allFinite());
      if (row.price == 0) {
        EXPECT_LE(ChanceExcess(row, Controls::Zero(), set.z), 1e-15);
        EXPECT_GE(FrozenRow(row, u_sent, set.z).hi, 0);
        EXPECT_GE(TangentCut(row, u_sent, set.z).hi, -1e-14);
        EXPECT_GE(WorstCaseRow(row, set.lb, set.ub, set.z).hi, 0);
      }
    }
    clamped += set.clamped;
    dropped += set.dropped;
  }
  EXPECT_GT(clamped, 100);  // the worlds are crowded enough to mean something
  EXPECT_GT(dropped, 10);
}

TEST(ConstraintBuilder, KeepsTheNearestRowsWhenThereAreTooMany) {
  Rng rng(2);
  ConstraintConfig config;
  ConstraintSet set;
  set.lb.setConstant(-1);
  RowMaker maker(config, 0, set);
  for (int i = 0; i < 300; ++i) {
    maker.Distance({RowKind::kVoxel, i, 0, rng.Uniform(0, 0.5), 1, 0}, Controls::Ones());
  }
  maker.Distance({RowKind::kVoxel, 999, 0, 0.001, 1, 0}, Controls::Ones());
  maker.Finish();
  EXPECT_TRUE(set.rows.full());
  EXPECT_EQ(set.dropped, 301 - kMaxPlainRows);
  bool found = false;
  double most = 0;
  for (const Row& row : set.rows) {
    found = found || row.key == RowKey(RowKind::kVoxel, 999, 0);
    most = std::max(most, row.hi);
  }
  EXPECT_TRUE(found);
  EXPECT_LT(most, 0.5 * kMaxPlainRows / 300 * 1.3);  // about the nearest third
}

/// The cones that `u` breaks, of the rows of all planes and pipes of the scene, built one by one.
int Broken(const ConstraintConfig& config, const Configuration& q, const Controls& u_sent,
           const Scene& scene, const DistanceField& field, const Controls& u) {
  int broken = 0;
  const auto count = [&](const Scene& alone) {
    static ConstraintSet set;
    Build(config, q, u_sent, alone, field, set);
    EXPECT_FALSE(set.chance.full());
    for (const ChanceRow& row : set.chance) {
      broken += ChanceExcess(row, u, set.z) > 1e-12 ? 1 : 0;
    }
  };
  for (const PlaneEstimate& plane : scene.planes) {
    Scene alone;
    EXPECT_TRUE(alone.planes.push_back(plane));
    count(alone);
  }
  for (const PipeEstimate& pipe : scene.pipes) {
    Scene alone;
    EXPECT_TRUE(alone.pipes.push_back(pipe));
    count(alone);
  }
  return broken;
}

/// A fast robot among more surfaces than there is room for: whatever it does in the box it is
/// given, as long as it keeps the rows it is given, it keeps those that were dropped.
TEST(ConstraintBuilder, NoControlThatKeepsTheRowsBreaksOneThatWasDropped) {
  const test::VoxelWorld world;
  int dropped = 0;
  int drawn_in = 0;
  int asked = 0;
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    Rng rng(6, i);
    ConstraintConfig config;
    config.alpha = 0.95;
    config.price.fill(0);
    config.price[static_cast<int>(RowKind::kRecovery)] = 5e3;
    const Configuration q = RandomConfiguration(rng);
    Scene scene;
    const Kinematics<kArmJoints> k(TracerUf7(), q);
    for (std::uint32_t p = 1; p <= 14; ++p) {  // about the robot, none of them touching it
      const Vector3d n = RandomDirection(rng);
      const double away_m = 1 + rng.Uniform(0, 0.2);
      ASSERT_TRUE(scene.planes.push_back(
          MakePlane(p, k.p_WS() - away_m * n, n, 3, rng.Uniform(0, 0.01), 0.01)));
      ASSERT_TRUE(scene.pipes.push_back(MakePipe(p, k.p_WS() + away_m * n, n.unitOrthogonal(), 0.06,
                                                 0.7, rng.Uniform(0, 0.02), 0.01)));
    }
    config.consider_m = 2;
    config.period_s = 0.1;  // much may change in it
    const Controls u_sent = 4 * RandomControls(rng);
    static ConstraintSet set;
    Build(config, q, u_sent, scene, world.field(), set);
    dropped += set.dropped;
    drawn_in += set.box_part < 1 ? 1 : 0;
    for (int draw = 0; draw < 20; ++draw) {
      Controls u;
      for (int c = 0; c < kControls; ++c) {
        u(c) = rng.Uniform() < 0.5 ? set.lb(c) : set.ub(c);
      }
      const auto keeps = [](const ChanceRow& row, const Controls& at) {
        return ChanceExcess(row, at, set.z) <= 1e-12;
      };
      for (const ChanceRow& row : set.chance) {  // back until the rows that are there hold
        while (!keeps(row, u)) {
          u *= u.cwiseAbs().maxCoeff() > 1e-3 ? 0.8 : 0;
        }
      }
      asked += u.isZero(0) ? 0 : 1;
      EXPECT_EQ(Broken(config, q, u_sent, scene, world.field(), u), 0);
    }
  }
  EXPECT_GT(dropped, 1000);
  EXPECT_GT(drawn_in, 5);
  EXPECT_GT(asked, 500);
}

TEST(ConstraintBuilder, AnUnseenWorldAllowsNoMotion) {
  ConstraintSet set;
  Build({}, test::HomeConfiguration(), Controls::Zero(), Scene{}, DistanceField{}, set);
  EXPECT_TRUE(set.lb.isZero(0));
  EXPECT_TRUE(set.ub.isZero(0));
}

TEST(ConstraintBuilder, TheBoxNeverLetsAJointPassItsLimit) {
  const test::VoxelWorld world;
  for (int i = 0; i < 200; ++i) {
    Rng rng(3, i);
    static ConstraintSet set;
    Configuration q = RandomConfiguration(rng);
    for (int step = 0; step < 5; ++step) {
      Build({}, q, 3 * RandomControls(rng), Scene{}, world.field(), set);
      q = Advance(q, rng.Uniform() < 0.5 ? set.ub : set.lb, 0.01);
      for (int j = 0; j < kArmJoints; ++j) {
        EXPECT_LE(q(3 + j), TracerUf7().arm.joints[j].q_max_rad);
        EXPECT_GE(q(3 + j), TracerUf7().arm.joints[j].q_min_rad);
      }
    }
  }
}

TEST(ConstraintBuilder, LimitsAccelerationButNotBraking) {
  const test::VoxelWorld world;
  ConstraintSet set;
  Controls u_sent = Controls::Zero();
  u_sent(0) = 0.2;
  Build({}, test::HomeConfiguration(), u_sent, Scene{}, world.field(), set);
  EXPECT_NEAR(set.ub(0), 0.2 + 0.008, 1e-12);  // 0.8 m/s² for 10 ms
  EXPECT_EQ(set.lb(0), 0);
  EXPECT_NEAR(set.ub(1), 0.02, 1e-12);
}

/// The row's bound of what a held u can take, against the motion itself.
TEST(HoldBuffer, BoundsWhatCurvatureTakesInAPeriod) {
  for (int i = 0; i < 500; ++i) {
    Rng rng(4, i);
    const Configuration q = RandomConfiguration(rng);
    const Kinematics<kArmJoints> now(TracerUf7(), q);
    const int body = rng.Index(Kinematics<kArmJoints>::kBodies);
    const Vector3d p_L = RandomIn(rng, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
    const Controls u = 5 * RandomControls(rng);
    constexpr double kPeriod = 0.01;
    const Mat<3, kControls> J = now.PointJacobian(body, p_L);
    const Kinematics<kArmJoints> then(TracerUf7(), Advance(q, u, kPeriod));
    const Vector3d off = then.Point(body, p_L) - now.Point(body, p_L) - kPeriod * (J * u);
    EXPECT_LE(off.norm(), kPeriod * HoldBuffer(J, u.cwiseAbs(), kPeriod) * 1.05 + 1e-12);
  }
}

TEST(ConstraintBuilder, FloorsDoNotConcernTheBaseAndWallsDo) {
  const test::VoxelWorld world;
  ConstraintSet set;
  Scene scene;
  ASSERT_TRUE(scene.planes.push_back(MakePlane(1, {0, 0, 0}, {0, 0, 1}, 2, 0, 0)));
  ASSERT_TRUE(scene.planes.push_back(MakePlane(2, {0.8, 0, 0.2}, {-1, 0, 0}, 1, 0, 0)));
  Build({}, test::HomeConfiguration(), Controls::Zero(), scene, world.field(), set);
  int base_rows = 0;
  for (const ChanceRow& row : set.chance) {
    if (row.key >> 26 == static_cast<int>(RowKind::kBasePlane)) {
      ++base_rows;
      EXPECT_EQ(row.key & 0xFFFF, 2);
      EXPECT_NEAR(row.b, 0.3, 1e-12);  // η (0.8 − 0.5)
      EXPECT_NEAR(row.a(0), 1, 1e-12);
    }
  }
  EXPECT_EQ(base_rows, 1);
}

}  // namespace
}  // namespace pipewright
