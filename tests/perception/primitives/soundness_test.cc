// SPDX-License-Identifier: MIT
#include "perception/primitives/soundness.h"

#include <gtest/gtest.h>

#include <limits>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

/// Rank 3: n turns about two axes, the plane shifts.
PlaneEstimate Plane() {
  PlaneEstimate plane;
  plane.n_W = Vector3d::UnitX();
  plane.e1_W = Vector3d::UnitY();
  plane.e2_W = Vector3d::UnitZ();
  plane.covariance.diagonal() << 0, 4e-4, 4e-4, 1e-4;
  plane.extent_hi_m[0] = plane.extent_hi_m[1] = 1;
  return plane;
}

PipeEstimate Pipe() {
  PipeEstimate pipe;
  pipe.l_W = Vector3d::UnitZ();
  pipe.radius_m = 0.05;
  pipe.covariance.diagonal() << 1e-5, 1e-5, 0, 1e-4, 1e-4, 0, 4e-6;
  pipe.extent_hi_m = 1;
  return pipe;
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Sound, IsAnEstimateWhoseCovarianceHasRoomForItsUnits) {
  EXPECT_TRUE(Sound(Plane()));
  EXPECT_TRUE(Sound(Pipe()));
  // Any G G' is, whatever its rank.
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    PipeEstimate pipe = Pipe();
    const int rank = 1 + rng.Index(7);
    pipe.covariance.setZero();
    for (int k = 0; k < rank; ++k) {
      Vec<7> g;
      for (int j = 0; j < 7; ++j) {
        g(j) = 1e-3 * rng.Normal();
      }
      pipe.covariance += g * g.transpose();
    }
    ASSERT_TRUE(Sound(pipe)) << i;
  }
}

TEST(Sound, IsNoPlaneThatCannotBe) {
  const auto broken = [](auto change) {
    PlaneEstimate plane = Plane();
    change(plane);
    return !Sound(plane);
  };
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.covariance.setZero(); }));
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.covariance(3, 3) = -1e-6; }));
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.covariance(1, 2) = p.covariance(2, 1) = 5e-4; }));
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.covariance(1, 3) = 1e-5; }));  // not symmetric
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.covariance(0, 0) = kNan; }));
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.n_W *= 1.01; }));
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.e1_W.setZero(); }));
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.d_m = kNan; }));
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.p_WCentroid.y() = kNan; }));
  EXPECT_TRUE(broken([](PlaneEstimate& p) { p.extent_hi_m[1] = -1; }));
}

TEST(Sound, IsNoPipeThatCannotBe) {
  const auto broken = [](auto change) {
    PipeEstimate pipe = Pipe();
    change(pipe);
    return !Sound(pipe);
  };
  EXPECT_TRUE(broken([](PipeEstimate& p) { p.covariance.setZero(); }));
  EXPECT_TRUE(broken([](PipeEstimate& p) { p.covariance(6, 6) = -1e-9; }));
  EXPECT_TRUE(broken([](PipeEstimate& p) { p.covariance(0, 4) = p.covariance(4, 0) = 1e-4; }));
  EXPECT_TRUE(broken([](PipeEstimate& p) { p.l_W *= 2; }));
  EXPECT_TRUE(broken([](PipeEstimate& p) { p.radius_m = 0; }));
  EXPECT_TRUE(broken([](PipeEstimate& p) { p.radius_m = kNan; }));
  EXPECT_TRUE(broken([](PipeEstimate& p) { p.extent_lo_m = 2; }));
}

}  // namespace
}  // namespace pipewright
