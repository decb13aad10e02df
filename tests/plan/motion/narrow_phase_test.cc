// SPDX-License-Identifier: MIT
#include "plan/motion/narrow_phase.h"

#include <gtest/gtest.h>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

Isometry3d RandomPose(Rng& rng, double reach_m) {
  const Eigen::Quaterniond turn(rng.Normal(), rng.Normal(), rng.Normal(), rng.Normal());
  Isometry3d X(turn.normalized());
  X.translation() = Vector3d{rng.Uniform(-reach_m, reach_m), rng.Uniform(-reach_m, reach_m),
                             rng.Uniform(-reach_m, reach_m)};
  return X;
}

double PointToShape(const BodyShape& shape, const Vector3d& p_G) {
  if (shape.kind == BodyShape::Kind::kBox) {
    return (p_G.cwiseAbs() - shape.half_m).cwiseMax(0).norm();
  }
  const Eigen::Vector2d beyond{p_G.head<2>().norm() - shape.half_m.x(),
                               std::abs(p_G.z()) - shape.half_m.z()};
  return beyond.cwiseMax(0).norm();
}

/// Least distance of a shape to a voxel's box by many points of the box: too large by at most half
/// a diagonal of the points' spacing.
double BruteDistance(const BodyShape& shape, const Isometry3d& X_WG, const Vector3d& center,
                     double half_m, int steps) {
  const Isometry3d X_GW = X_WG.inverse();
  double least = 1e9;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      for (int k = 0; k <= steps; ++k) {
        const Vector3d p = center + half_m * (2.0 / steps * Vector3d(i, j, k) - Vector3d::Ones());
        least = std::min(least, PointToShape(shape, X_GW * p));
      }
    }
  }
  return least;
}

MapConfig SmallMap() {
  MapConfig config;
  config.lo = {-8, -8, -8};
  config.hi = {7, 7, 7};
  config.workspace_lo = config.lo;
  config.workspace_hi = config.hi;
  config.brick_capacity = BricksOfBox(config);
  return config;
}

TEST(MeetsObstacle, AgreesWithManyPointsOfTheVoxel) {
  constexpr int kSteps = 24;
  constexpr double kSpacing_m = 0.05 / kSteps * 0.87;
  VoxelGrid map(SmallMap());
  map.MarkSweptSphere(Vector3d::Zero(), 2);
  const Vector3f point(0.01F, 0.01F, 0.01F);
  static_cast<void>(map.InsertScan(&point, 1, point, -1));
  const Vector3d center = map.Center({0, 0, 0});
  Rng rng(51);
  int near = 0;
  for (int trial = 0; trial < 600; ++trial) {
    BodyShape shape;
    shape.kind = trial % 2 == 0 ? BodyShape::Kind::kBox : BodyShape::Kind::kCylinder;
    shape.half_m = {rng.Uniform(0.01, 0.1), rng.Uniform(0.01, 0.1), rng.Uniform(0.01, 0.1)};
    if (trial % 2 == 1) {
      shape.half_m.y() = shape.half_m.x();
    }
    const Isometry3d X_WG = RandomPose(rng, 0.15);
    const double margin_m = rng.Uniform(0, 0.06);
    const double distance_m = BruteDistance(shape, X_WG, center, 0.025, kSteps);
    if (std::abs(distance_m - margin_m) < kSpacing_m) {
      continue;  // too close for the oracle to say
    }
    ++near;
    EXPECT_EQ(MeetsObstacle(shape, X_WG, margin_m, map), distance_m < margin_m)
        << "distance " << distance_m << ", margin " << margin_m;
  }
  EXPECT_GT(near, 500);
}

TEST(MeetsObstacle, UnknownIsAnObstacleUntilItIsSwept) {
  VoxelGrid map(SmallMap());
  const BodyShape shape{.half_m = {0.02, 0.02, 0.02}};
  EXPECT_TRUE(MeetsObstacle(shape, Isometry3d::Identity(), 0.01, map));
  map.MarkSweptSphere(Vector3d::Zero(), 0.2);
  EXPECT_FALSE(MeetsObstacle(shape, Isometry3d::Identity(), 0.01, map));
}

TEST(SegmentDistance, AgreesWithManyPairsOfPoints) {
  constexpr int kSteps = 200;
  Rng rng(52);
  for (int trial = 0; trial < 60; ++trial) {
    Vector3d p[4];
    for (Vector3d& point : p) {
      point = RandomPose(rng, 1).translation();
    }
    if (trial % 10 == 1) {
      p[1] = p[0];  // a point
    } else if (trial % 10 == 2) {
      p[3] = p[2];
    } else if (trial % 10 == 3) {
      p[3] = p[2] + 0.5 * (p[1] - p[0]);  // parallel
    }
    double least = 1e9;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        least = std::min(least, (p[0] + 1.0 * i / kSteps * (p[1] - p[0]) - p[2] -
                                 1.0 * j / kSteps * (p[3] - p[2]))
                                    .norm());
      }
    }
    const double distance = SegmentDistance(p[0], p[1], p[2], p[3]);
    EXPECT_LE(distance, least + 1e-12);
    EXPECT_GT(distance, least - 0.02) << "half a step of either segment";
  }
}

TEST(SegmentBoxDistance, AgreesWithManyPoints) {
  constexpr int kSteps = 2000;
  Rng rng(53);
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3d a = RandomPose(rng, 1).translation();
    const Vector3d b = RandomPose(rng, 1).translation();
    const Vector3d half{rng.Uniform(0.05, 0.5), rng.Uniform(0.05, 0.5), rng.Uniform(0.05, 0.5)};
    double least = 1e9;
    for (int i = 0; i <= kSteps; ++i) {
      const Vector3d p = a + 1.0 * i / kSteps * (b - a);
      least = std::min(least, (p.cwiseAbs() - half).cwiseMax(0).norm());
    }
    EXPECT_NEAR(SegmentBoxDistance(a, b, half), least, 1e-3);
  }
}

}  // namespace
}  // namespace pipewright
