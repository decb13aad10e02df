// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "ctrl/constraints/constraint_set.h"
#include "platform/core/normal.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::RandomDirection;
using test::RandomIn;

TEST(JointChanceQuantile, TheRisksOfAllRowsAddUpToNoMoreThanOneMinusAlpha) {
  for (const double alpha : {0.5, 0.7, 0.9, 0.95, 0.99, 0.999}) {
    for (int rows = 1; rows <= kMaxChanceRows; ++rows) {
      const Result<double> z = JointChanceQuantile(alpha, rows);
      ASSERT_TRUE(z.ok());
      // z was rounded: half an ulp of it is some 1e-15 of the risk.
      const double sum = rows * NormalCdf(-*z);
      EXPECT_LE(sum, (1 - alpha) * (1 + 1e-14)) << alpha << ", " << rows << " rows";
      EXPECT_GE(sum, (1 - alpha) * (1 - 1e-14));
    }
  }
}

TEST(JointChanceQuantile, OneRowHasItAllAndMoreRowsAskForMore) {
  for (const double alpha : {0.5, 0.7, 0.99}) {
    EXPECT_EQ(*JointChanceQuantile(alpha, 0), *ChanceQuantile(alpha));
    EXPECT_EQ(*JointChanceQuantile(alpha, 1), *ChanceQuantile(alpha));
    for (int rows = 2; rows <= kMaxChanceRows; ++rows) {
      EXPECT_GT(*JointChanceQuantile(alpha, rows), *JointChanceQuantile(alpha, rows - 1));
    }
  }
  EXPECT_EQ(JointChanceQuantile(0.4, 3).status(), Status::kOutOfRange);
}

TEST(ConstraintBuilder, SharesTheRiskAmongTheRowsThatAreThere) {
  static ConstraintSet alone;
  static ConstraintSet joint;
  const test::VoxelWorld world;
  const Configuration q = test::HomeConfiguration();
  const Kinematics<kArmJoints> k(TracerUf7(), q);
  int most = 0;
  for (int i = 0; i < 30; ++i) {
    Rng rng(1, i);
    Scene scene;
    for (std::uint32_t p = 1; p <= 1 + static_cast<std::uint32_t>(i) % 6; ++p) {
      const Vector3d n = RandomDirection(rng);
      ASSERT_TRUE(scene.planes.push_back(test::MakePlane(p, RandomIn(rng, {-1, -1, 0}, {1, 1, 1}),
                                                         n, rng.Uniform(0.1, 1), 0.01, 0.01)));
    }
    ConstraintConfig config;
    config.alpha = 0.9;
    ConstraintBuilder(config, TracerUf7(), TracerUf7Shapes())
        .Build(q, k, Controls::Zero(), scene, world.field(), alone);
    config.joint_risk = true;
    ConstraintBuilder(config, TracerUf7(), TracerUf7Shapes())
        .Build(q, k, Controls::Zero(), scene, world.field(), joint);
    const int rows = joint.chance.size();
    most = std::max(most, rows);
    EXPECT_EQ(rows, alone.chance.size());
    EXPECT_EQ(joint.z, *JointChanceQuantile(0.9, rows + joint.dropped));  // they share it, too
    EXPECT_EQ(joint.dropped, alone.dropped);
    EXPECT_EQ(joint.clearance.plane_m, alone.clearance.plane_m);
    for (const ChanceRow& row : joint.chance) {  // hard or soft, made with the z that is told
      EXPECT_TRUE(row.price > 0 || row.limit >= joint.z * std::sqrt(row.cone.c));
    }
    for (int r = 0; r < rows && !joint.chance.full(); ++r) {
      EXPECT_EQ(joint.chance[r].b, alone.chance[r].b);
    }
  }
  EXPECT_GT(most, 30);
}

}  // namespace
}  // namespace pipewright
