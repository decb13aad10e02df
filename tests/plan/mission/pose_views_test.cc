// SPDX-License-Identifier: MIT
#include "plan/mission/pose_views.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/map/distance_field.h"
#include "plan/cfnbv/proposals.h"
#include "tests/plan/gain/toy_map.h"

namespace pipewright {
namespace {

/// A hall, all of it known; of walls and floor what is asked for stands.
struct Hall {
  static constexpr int kHalf = 36;  ///< voxels from the middle to the walls
  enum Part : std::uint8_t { kFloor = 1, kWallAtX = 2, kWallAtY = 4 };

  explicit Hall(int parts) {
    test::ForEachVoxel(Config().lo, Config().hi, [&](const VoxelIndex& v) {
      const bool occupied = ((parts & kFloor) != 0 && v.z == Config().lo.z) ||
                            ((parts & kWallAtX) != 0 && v.x == kHalf) ||
                            ((parts & kWallAtY) != 0 && v.y == kHalf);
      map.Restore(v, occupied ? 2 : -2);
    });
    field.Update(map);
  }

  static MapConfig Config() {
    MapConfig config;
    config.lo = {-kHalf, -kHalf, -2};
    config.hi = {kHalf, kHalf, 40};
    config.workspace_lo = config.lo;
    config.workspace_hi = config.hi;
    config.brick_capacity = BricksOfBox(config);
    return config;
  }

  Surroundings around() const { return {field, map, scene}; }

  VoxelGrid map{Config()};
  DistanceField field{Config()};
  Scene scene;
};

Vector3d Axis(const Configuration& q) { return ViewpointOf(q).X_WS.linear().col(2); }

/// A posture whose camera looks that way, level.
Configuration Looking(double azimuth_rad) {
  Configuration q = Configuration::Zero();
  q.tail<kArmJoints>() << 0, 0.4, 0, 1.0, 0, 0, 0;
  Configuration level = q;
  for (double nod_rad = -1.5; nod_rad < 3; nod_rad += 0.01) {
    q(3 + 5) = nod_rad;
    if (std::abs(Axis(q).z()) < std::abs(Axis(level).z())) {
      level = q;
    }
  }
  q = level;
  const Vector3d ahead = Axis(q);
  q(2) = azimuth_rad - std::atan2(ahead.y(), ahead.x());
  return q;
}

RaySet Camera() {
  GainConfig config;
  config.rays = 200;
  return LatticeCameraRays(config);
}

constexpr double kAtX = 0;
constexpr double kAtY = 1.5707963267948966;

TEST(PoseViews, AWallTellsHowFarItIsAndTheHeadingAndNothingAlongIt) {
  const Hall hall(Hall::kWallAtX);
  PoseViews views;
  const PoseViewsConfig config;
  const Configuration q = Looking(kAtX);
  const Mat<3, 3> I = views.Information(q, hall.around(), Camera());
  // The wall is n = -x; its points are where the rays meet the plane.
  const Isometry3d X_WS = ViewpointOf(q).X_WS;
  const double wall_m = Hall::kHalf * Hall::Config().width_m;
  Mat<3, 3> expected = Mat<3, 3>::Zero();
  for (const Vector3d& d_S : Camera().directions) {
    const Vector3d d = X_WS.linear() * d_S;
    const double s_m = (wall_m - X_WS.translation().x()) / d.x();
    const Vector3d p = X_WS.translation() + s_m * d;
    if (d.x() > config.cosine_min && s_m < config.range_m && p.z() > -0.1) {
      const Vector3d J(-1, 0, p.y());
      expected += J * J.transpose() / (config.sigma_m * config.sigma_m);
    }
  }
  ASSERT_GT(expected(0, 0), 0);
  EXPECT_LE((I - expected).norm(), 0.1 * expected.norm()) << I << "\n\n" << expected;
  EXPECT_LE(std::abs(I(1, 1)), 0.01 * I(0, 0));
}

TEST(PoseViews, AFloorTellsNothing) {
  const Hall hall(Hall::kFloor);
  PoseViews views;
  Configuration q = Looking(kAtX);
  q(3 + 5) += 0.8;
  ASSERT_LT(Axis(q).z(), -0.5) << "down";
  EXPECT_EQ(views.Information(q, hall.around(), Camera()).norm(), 0);
  const PoseViewsConfig config;
  EXPECT_NEAR(views.VarianceAfter(q, hall.around(), Camera()),
              2 * config.before_m * config.before_m + config.before_rad * config.before_rad, 1e-12);
}

TEST(PoseViews, WhatIsBehindUnknownVoxelsTellsNothing) {
  Hall hall(Hall::kWallAtX);
  VoxelGrid unknown(Hall::Config());
  PoseViews views;
  EXPECT_EQ(views.Information(Looking(kAtX), {hall.field, unknown, hall.scene}, Camera()).norm(),
            0);
}

TEST(PoseViews, ACornerTellsMoreThanAWall) {
  const Hall hall(Hall::kWallAtX | Hall::kWallAtY);
  PoseViews views;
  const double corner = views.VarianceAfter(Looking(kAtY / 2), hall.around(), Camera());
  EXPECT_LT(corner, views.VarianceAfter(Looking(kAtX), hall.around(), Camera()));
  EXPECT_LT(corner, views.VarianceAfter(Looking(kAtY), hall.around(), Camera()));
}

TEST(PoseViews, FindsFreePosturesBestFirst) {
  const Hall hall(Hall::kFloor | Hall::kWallAtX);
  const CollisionChecker checker(hall.around());
  PoseViews views;
  Configuration q = Looking(kAtX + 2.5);  // away from the wall
  ASSERT_TRUE(checker.Free(q));
  const double before = views.VarianceAfter(q, hall.around(), Camera());
  Rng rng(5);
  PoseViews::Views best;
  views.Find(checker, q, Camera(), rng, best);
  ASSERT_EQ(best.size(), PoseViews::kMost);
  double last = 0;
  for (const ArmVector& posture : best) {
    q.tail<kArmJoints>() = posture;
    EXPECT_TRUE(checker.Free(q));
    const double variance = views.VarianceAfter(q, hall.around(), Camera());
    EXPECT_GE(variance, last);
    EXPECT_LT(variance, 0.8 * before);
    last = variance;
  }
}

}  // namespace
}  // namespace pipewright
