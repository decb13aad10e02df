// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "plan/gain/gain.h"
#include "tests/plan/gain/gain_fixture.h"

namespace pipewright {
namespace {

using test::RandomDirection;

TEST(UprightViewpoint, LooksAlongItsAxisWithTheImageUpright) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Vector3d z_WS = RandomDirection(rng);
    const Matrix3d R = UprightViewpoint({1, 2, 3}, z_WS).X_WS.linear();
    EXPECT_NEAR((R * R.transpose() - Matrix3d::Identity()).norm(), 0, 1e-12);
    EXPECT_NEAR(R.determinant(), 1, 1e-12);
    EXPECT_EQ(R.col(2), z_WS);
    EXPECT_NEAR(R(2, 0), 0, 1e-12);  // x_S is horizontal
    EXPECT_LE(R(2, 1), 1e-12);       // y_S points down
  }
  for (const double up : {1.0, -1.0}) {
    const Matrix3d R = UprightViewpoint({0, 0, 0}, {0, 0, up}).X_WS.linear();
    EXPECT_EQ(R.col(0), Vector3d(0, -1, 0));
    EXPECT_NEAR(R.determinant(), 1, 1e-12);
  }
}

TEST(RaySets, LieWithinTheFieldOfViewAndFillIt) {
  const GainConfig config;
  Rng rng(5);
  for (const RaySet& rays : {RandomCameraRays(config, rng), LatticeCameraRays(config)}) {
    ASSERT_EQ(rays.directions.size(), config.rays);
    double x_max = 0;
    double y_max = 0;
    for (const Vector3d& d : rays.directions) {
      EXPECT_NEAR(d.norm(), 1, 1e-12);
      x_max = std::max(x_max, std::abs(std::atan2(d.x(), d.z())));
      y_max = std::max(y_max, std::abs(std::atan2(d.y(), d.z())));
    }
    EXPECT_LE(x_max, config.fov_x_rad / 2 + 1e-12);
    EXPECT_LE(y_max, config.fov_y_rad / 2 + 1e-12);
    EXPECT_GT(x_max, 0.9 * config.fov_x_rad / 2);
    EXPECT_GT(y_max, 0.9 * config.fov_y_rad / 2);
  }
}

TEST(RaySets, SphereRaysAreUnitVectorsWithoutAPreferredSide) {
  const GainConfig config{.rays = 512};
  Rng rng(6);
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& d : RandomSphereRays(config, rng).directions) {
    EXPECT_NEAR(d.norm(), 1, 1e-12);
    sum += d;
  }
  EXPECT_LT(sum.norm() / 512, 0.1);  // standard deviation of the mean: 1 / sqrt(512) = 0.044
}

}  // namespace
}  // namespace pipewright
