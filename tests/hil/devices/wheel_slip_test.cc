// SPDX-License-Identifier: MIT
#include "hil/devices/wheel_slip.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pipewright::hil {
namespace {

constexpr double kTrack_m = 0.35;

TEST(WheelSlip, WithoutFaultsTheBaseMovesAsItsWheelsTell) {
  WheelSlip slip({});
  slip.Roll(3, -2);
  const BaseMotion motion = slip.Motion({0.2, -0.7}, kTrack_m);
  EXPECT_EQ(motion.v_mps, 0.2);
  EXPECT_EQ(motion.omega_radps, -0.7);
}

TEST(WheelSlip, TurnsFartherThanToldTheMoreTheSlower) {
  const WheelSlip slip({.yaw_scale_slow = 1.06, .yaw_scale_fast = 1.03});
  struct Case {
    double told_radps;
    double scale;
  };
  for (const Case& c : {Case{0.01, 1.06}, Case{0.3, 1.06}, Case{-0.3, 1.06}, Case{0.45, 1.045},
                        Case{0.6, 1.03}, Case{-2, 1.03}}) {
    const BaseMotion motion = slip.Motion({0.2, c.told_radps}, kTrack_m);
    EXPECT_NEAR(motion.omega_radps, c.scale * c.told_radps, 1e-12) << c.told_radps;
    EXPECT_NEAR(motion.v_mps, 0.2, 1e-12);
  }
}

TEST(WheelSlip, AWetWheelPullsTheBaseToItsSideUntilItIsDry) {
  WheelSlip slip({});
  slip.Spill(0.5, 0);
  const BaseMotion wet = slip.Motion({0.2, 0}, kTrack_m);
  EXPECT_DOUBLE_EQ(wet.v_mps, 0.15);
  EXPECT_DOUBLE_EQ(wet.omega_radps, 0.1 / kTrack_m);
  slip.Spill(0, 0);
  EXPECT_DOUBLE_EQ(slip.Motion({0.2, 0}, kTrack_m).omega_radps, 0);
}

TEST(WheelSlip, WhatIsLostSpreadsWithTheRootOfTheWay) {
  constexpr double kSigma = 0.1;
  constexpr double kMean = 0.02;
  constexpr int kDrives = 2000;
  constexpr double kStep_m = 0.001;
  for (const double way_m : {1.0, 4.0}) {
    double sum = 0;
    double square = 0;
    for (int drive = 0; drive < kDrives; ++drive) {
      WheelSlip slip({.slip = kMean, .slip_sigma = kSigma, .seed = 100U + drive});
      double lost_m = 0;
      for (double rolled_m = 0; rolled_m < way_m; rolled_m += kStep_m) {
        // The left wheel alone rolls: v is half of what it does.
        lost_m += kStep_m - 2 * slip.Motion({kStep_m / 2, -kStep_m / kTrack_m}, kTrack_m).v_mps;
        slip.Roll(kStep_m, 0);
      }
      sum += lost_m;
      square += lost_m * lost_m;
    }
    const double mean = sum / kDrives;
    const double sigma = std::sqrt(square / kDrives - mean * mean);
    EXPECT_NEAR(mean, kMean * way_m, 5 * sigma / std::sqrt(kDrives));
    EXPECT_NEAR(sigma, kSigma * std::sqrt(0.05 * way_m), 0.08 * sigma);
  }
}

TEST(WheelSlip, OneSeedGivesOneDrive) {
  const WheelSlipConfig config{.slip_sigma = 0.1, .seed = 7};
  WheelSlip a(config);
  WheelSlip b(config);
  for (int i = 0; i < 1000; ++i) {
    a.Roll(0.01, 0.02);
    b.Roll(0.01, 0.02);
    ASSERT_EQ(a.Motion({0.1, 0.2}, kTrack_m).omega_radps,
              b.Motion({0.1, 0.2}, kTrack_m).omega_radps);
  }
}

}  // namespace
}  // namespace pipewright::hil
