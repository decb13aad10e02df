// SPDX-License-Identifier: MIT
// How slippery the floor is, as the pose filter finds it, and what it then makes of fixes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "perception/localization/pose_filter.h"
#include "platform/core/rng.h"

namespace pipewright {
namespace {

using std::chrono::milliseconds;

constexpr double kTrack_m = 0.35;

struct Outcome {
  double slip = 0;
  double filter_m = 0;  ///< largest errors
  double filter_rad = 0;
  double wheels_m = 0;
};

/// A minute at 0.2 m/s to and fro, by wheels that slip `slip` times as usual, with fixes that err
/// by a millimetre, the same way for a second.
Outcome Drive(double slip, double fix_m, std::uint64_t seed) {
  PoseFilter filter({.odometry = {.track_m = kTrack_m, .quantum_m = 1e-9}});
  const WheelSlip usual = PoseFilterConfig{}.slip;
  Rng rng(seed);
  Vector3d truth = Vector3d::Zero();
  Vector3d bias = Vector3d::Zero();
  double left = 0;
  double right = 0;
  Outcome worst;
  (void)filter.Step(Time{}, 0, 0, 0, 0);
  for (int k = 1; k <= 3000; ++k) {
    const double s = 0.004 * std::sin(0.01 * k);
    const double t = 0.008 * std::cos(0.013 * k);
    left += s - t * kTrack_m / 2;
    right += s + t * kTrack_m / 2;
    const double s_true = s + slip * usual.m * std::sqrt(std::abs(s)) * rng.Normal();
    const double t_true =
        t + slip * usual.rad_per_m * std::sqrt(std::abs(s) + std::abs(t)) * rng.Normal();
    truth = AlongArc(truth, {s_true, t_true});
    (void)filter.Step(Time{milliseconds(20 * k)}, s / 0.02, t / 0.02, left, right);
    if (k % 50 == 1) {
      bias = fix_m * Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
    }
    if (k % 3 == 0) {
      PoseFix fix{.stamp = Time{milliseconds(20 * k)}, .pose = truth + bias};
      fix.information = Mat<3, 3>::Identity() * 4e6;
      (void)filter.Correct(fix);
    }
    const BasePose pose = filter.pose();
    const BasePose& wheels = filter.odometry().pose();
    worst.filter_m =
        std::max(worst.filter_m, std::hypot(pose.x_m - truth.x(), pose.y_m - truth.y()));
    worst.filter_rad = std::max(worst.filter_rad, std::abs(pose.phi_rad - truth.z()));
    worst.wheels_m =
        std::max(worst.wheels_m, std::hypot(wheels.x_m - truth.x(), wheels.y_m - truth.y()));
  }
  worst.slip = filter.slip();
  return worst;
}

TEST(FloorSlip, IsFoundByTheFixes) {
  const Outcome dry = Drive(0, 1e-3, 1);
  const Outcome wet = Drive(5, 1e-3, 2);
  EXPECT_EQ(dry.slip, PoseFilterConfig{}.slip_least);
  EXPECT_GT(wet.slip, 1.5);
}

/// Wheels that roll true stay better than fixes that err together.
TEST(FloorSlip, OnDryFloorFixesDoNotPullThePoseByMoreThanTheyErr) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Outcome dry = Drive(0, 1e-3, seed);
    EXPECT_LT(dry.filter_m, 4e-3) << seed;  // of sixty errors of 1 mm a way, the largest
    EXPECT_LT(dry.filter_rad, 4e-3) << seed;
  }
}

TEST(FloorSlip, OnWetFloorFixesHoldThePose) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Outcome wet = Drive(5, 1e-3, seed);
    EXPECT_LT(wet.filter_m, 0.02) << seed;
    EXPECT_GT(wet.wheels_m, 0.05) << seed << ": the wheels alone must fail this";
  }
}

}  // namespace
}  // namespace pipewright
