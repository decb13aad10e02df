// SPDX-License-Identifier: MIT
// When the pose filter doubts its pose, and what ends that.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "perception/localization/pose_filter.h"
#include "platform/core/rng.h"
#include "tests/perception/localization/drive.h"

namespace pipewright {
namespace {

using test::Drive;
using test::Fine;
using test::Information;
using test::kTrack_m;
using test::PoseOf;

/// A base on its way, and fixes of where it is plus what they lie.
struct Ride {
  Status See(const Vector3d& lie, double v_mps = 0.1, double sigma = 1e-3) {
    for (int k = 0; k < 3; ++k) {  // a frame's time
      (void)drive.Run(filter, v_mps, 0);
    }
    return filter.Correct(
        {.stamp = drive.now, .pose = drive.truth + lie, .information = Information(sigma, sigma)});
  }
  void SeeWell(int fixes, double v_mps = 0.1) {
    for (int k = 0; k < fixes; ++k) {
      ASSERT_EQ(See(Vector3d::Zero(), v_mps), Status::kOk);
    }
  }
  /// Reports without a frame, on which the base turns by what no wheel tells.
  void OnASpill(int reports, double v_mps, double turn_rad) {
    for (int k = 0; k < reports; ++k) {
      (void)drive.Run(filter, v_mps, 0);
      drive.truth.z() += turn_rad / reports;
    }
  }
  Vector3d Error() const { return PoseOf(filter) - drive.truth; }

  PoseFilter filter{Fine()};
  Drive drive;
};

TEST(PoseDoubt, OneFixThatLiesStopsTheRobotButDoesNotPullIt) {
  Ride ride;
  ride.SeeWell(60);
  const Mat<3, 3> before = ride.filter.pose().covariance;
  EXPECT_EQ(ride.See({0.2, -0.1, 0.3}), Status::kInfeasible);
  EXPECT_TRUE(ride.filter.doubted());
  EXPECT_LT(ride.Error().norm(), 1e-3);
  EXPECT_LT(ride.filter.pose().covariance.trace(), 1.2 * before.trace()) << "one is no evidence";
  ride.SeeWell(PoseFilterConfig{}.agreement - 1, 0);
  EXPECT_TRUE(ride.filter.doubted());
  ride.SeeWell(1, 0);
  EXPECT_FALSE(ride.filter.doubted());
  EXPECT_EQ(ride.filter.refused(), 1U);
  EXPECT_EQ(ride.filter.doubts(), 1U);
  EXPECT_EQ(ride.filter.slips(), 0U);
  EXPECT_FALSE(ride.filter.lost());
}

TEST(PoseDoubt, FixesThatLieEachInItsOwnWayNeverPullIt) {
  Ride ride;
  Rng rng(5);
  ride.SeeWell(60);
  for (int k = 0; k < 200; ++k) {
    const Vector3d lie(rng.Uniform(-0.25, 0.25), rng.Uniform(-0.25, 0.25), rng.Uniform(-0.4, 0.4));
    if (lie.cwiseAbs().minCoeff() > 0.05) {
      EXPECT_EQ(ride.See(lie, 0), Status::kInfeasible);
    }
  }
  EXPECT_GT(ride.filter.refused(), 50U);
  EXPECT_LT(ride.Error().norm(), 1e-3);
  EXPECT_TRUE(ride.filter.doubted());
}

/// The base was pushed, or slid: the fixes are right and the wheels know nothing.
TEST(PoseDoubt, FixesOfOneOpinionAreBelieved) {
  for (const Vector3d& push : {Vector3d(0.06, 0, 0), Vector3d(-0.1, 0.15, -0.3)}) {
    Ride ride;
    ride.SeeWell(60);
    for (int k = 1; k < PoseFilterConfig{}.agreement; ++k) {
      EXPECT_EQ(ride.See(push, 0), Status::kInfeasible) << k;
      EXPECT_LT(ride.Error().norm(), 1e-3);
    }
    EXPECT_EQ(ride.See(push, 0), Status::kOk);
    EXPECT_LT((ride.Error() - push).norm(), 5e-3);
    for (int k = 1; k < PoseFilterConfig{}.agreement; ++k) {
      EXPECT_EQ(ride.See(push, 0), Status::kOk);
    }
    EXPECT_FALSE(ride.filter.doubted());
    EXPECT_EQ(ride.filter.slips(), 1U);
    EXPECT_FALSE(ride.filter.lost());
  }
}

/// A spill on the way turns the base, of which the fixes tell; of x they tell nothing, and there
/// the wheels may have lost as much.
TEST(PoseDoubt, BelievedFixesLeaveItUnsureWhereTheyTellNothing) {
  constexpr double kTurned_rad = 0.1;
  Ride ride;
  ride.SeeWell(60);
  const double before = std::sqrt(ride.filter.pose().covariance(0, 0));
  ride.OnASpill(25, 0.3, kTurned_rad);
  PoseFix fix{.pose = ride.drive.truth};
  fix.information = Vector3d(0, 1e6, 1e6).asDiagonal();
  for (int k = 0; k < 2 * PoseFilterConfig{}.agreement; ++k) {
    (void)ride.drive.Run(ride.filter, 0, 0);
    fix.stamp = ride.drive.now;
    (void)ride.filter.Correct(fix);
  }
  ASSERT_EQ(ride.filter.slips(), 1U);
  EXPECT_NEAR(ride.Error().y(), 0, 2e-3);
  EXPECT_NEAR(ride.Error().z(), 0, 5e-3);
  const double now = std::sqrt(ride.filter.pose().covariance(0, 0));
  EXPECT_GT(now, 4 * before);
  EXPECT_LT(now, 0.03) << "of 15 cm on the way";
  EXPECT_LT(std::sqrt(ride.filter.pose().covariance(1, 1)), 8e-3);
}

/// Of one opinion, but of a part of the pose only, by a base that stands: no wheel slipped, so what
/// they were found among is elsewhere.
TEST(PoseDoubt, FixesOfAPartThatNoWheelCanHaveSlippedByAreNotBelieved) {
  Ride ride;
  ride.SeeWell(60);
  PoseFix fix{.pose = ride.drive.truth + Vector3d(-0.05, 0, 0.01)};
  fix.information = Vector3d(1e6, 0, 1e4).asDiagonal();
  for (int k = 0; k < 50; ++k) {
    (void)ride.drive.Run(ride.filter, 0, 0);
    fix.stamp = ride.drive.now;
    EXPECT_EQ(ride.filter.Correct(fix), Status::kInfeasible);
  }
  EXPECT_LT(ride.Error().norm(), 1e-3);
  EXPECT_TRUE(ride.filter.doubted());
  EXPECT_EQ(ride.filter.slips(), 0U);
}

/// The worst covariance grows with the wheels' way alone, and fixes take it back.
TEST(PoseDoubt, TheWorstIsAsFarAsWheelsTurn) {
  Ride ride;
  ride.SeeWell(60, 0);
  const Mat<3, 3> sure = ride.filter.worst_covariance();
  for (int k = 0; k < 500; ++k) {
    (void)ride.drive.Run(ride.filter, 0, 0);
  }
  EXPECT_LT((ride.filter.worst_covariance() - sure).norm(), 1e-9);
  for (int k = 0; k < 50; ++k) {
    (void)ride.drive.Run(ride.filter, 0.3, 0);
  }
  const double turn_rad = std::sqrt(ride.filter.worst_covariance()(2, 2));
  const PoseFilterConfig config;
  EXPECT_NEAR(turn_rad, config.slip_worst * config.slip.rad_per_m * std::sqrt(0.3), 0.1 * turn_rad);
  EXPECT_GT(turn_rad, 5 * std::sqrt(ride.filter.pose().covariance(2, 2)));
  ride.SeeWell(2, 0);
  EXPECT_LT(std::sqrt(ride.filter.worst_covariance()(2, 2)), 5e-3);
}

/// A base that drives towards the only wall in sight, and turns as the left wheel slips. The wall
/// is farther than it should be, which the slip's turn and a way would both explain: the truth must
/// stay within what the filter states, and heading must be taken to have turned.
TEST(PoseDoubt, AWheelThatSlipsTurnsTheBaseMoreThanItKeepsItBack) {
  constexpr double kLost_m = 0.03;
  constexpr double kLever_m = 0.8;  // beside the wall's point that is seen
  Ride ride;
  ride.SeeWell(60);
  ride.OnASpill(17, 0.3, 0);
  const Vector3d slip(-kLost_m / 2, 0, kLost_m / kTrack_m);
  const Vector3d d(1, 0, kLever_m);
  for (int k = 0; k < 2 * PoseFilterConfig{}.agreement; ++k) {
    (void)ride.drive.Run(ride.filter, 0, 0);
    const Vector3d now = PoseOf(ride.filter);
    const double off = d.dot(ride.drive.truth + slip - now) / d.squaredNorm();
    (void)ride.filter.Correct(
        {.stamp = ride.drive.now, .pose = now + off * d, .information = 1e6 * d * d.transpose()});
  }
  ASSERT_EQ(ride.filter.slips(), 1U);
  const Vector3d error = ride.Error() - slip;
  const Mat<3, 3> P = ride.filter.pose().covariance;
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(error(i)), 2 * std::sqrt(P(i, i))) << i;
  }
  EXPECT_LT(std::abs(error.z()), 0.5 * std::abs(slip.z()));
}

/// A wheel on something wet, too little for the gate: heading tells, the way along the wall does
/// not, and the pose gets unsure there, too.
TEST(PoseDoubt, ASurpriseInOneDirectionMakesItUnsureInAll) {
  Ride ride;
  ride.SeeWell(60);
  PoseFix fix;
  fix.information = Vector3d(0, 1e6, 1e6).asDiagonal();
  const auto see = [&](double turned_rad) {
    for (int k = 0; k < 3; ++k) {
      (void)ride.drive.Run(ride.filter, 0.3, 0);
    }
    ride.drive.truth.z() += turned_rad;
    fix.stamp = ride.drive.now;
    fix.pose = ride.drive.truth;
    return ride.filter.Correct(fix);
  };
  const double slip = ride.filter.slip();
  const double before = ride.filter.pose().covariance(0, 0);
  ASSERT_EQ(see(0), Status::kOk);
  const double usual = ride.filter.pose().covariance(0, 0) - before;
  ASSERT_EQ(see(0.01), Status::kOk);
  EXPECT_FALSE(ride.filter.doubted());
  EXPECT_GT(ride.filter.slip(), 2 * slip);
  EXPECT_GT(ride.filter.pose().covariance(0, 0) - before - usual, 1.5 * usual);
}

TEST(PoseDoubt, IsNotEndedByFixesTooFarToBeFoundAgain) {
  const double far_m = PoseFilterConfig{}.lost_m + 0.05;
  Ride ride;
  ride.SeeWell(60);
  for (int k = 0; k < 50; ++k) {
    EXPECT_EQ(ride.See({far_m, 0, 0}, 0), Status::kInfeasible);
  }
  EXPECT_LT(ride.Error().norm(), 1e-3);
  EXPECT_TRUE(ride.filter.doubted());
}

TEST(PoseDoubt, ComesOfScansThatFitNowhereOnlyWhenTheyInsist) {
  Ride ride;
  ride.SeeWell(60);
  for (int k = 1; k <= PoseFilterConfig{}.patience; ++k) {
    EXPECT_FALSE(ride.filter.doubted()) << k;
    (void)ride.drive.Run(ride.filter, 0.1, 0);
    EXPECT_EQ(ride.filter.Correct({.stamp = ride.drive.now, .fits = false}), Status::kInfeasible);
    EXPECT_LT(ride.Error().norm(), 1e-3);
  }
  EXPECT_TRUE(ride.filter.doubted());
  ride.SeeWell(PoseFilterConfig{}.agreement, 0);
  EXPECT_FALSE(ride.filter.doubted());
}

/// One wheel on a spill: for a second the base turns by 15 degrees of which no wheel tells. The
/// fixes are right all the while.
TEST(PoseDoubt, IsFoundByFixesWhileItSlips) {
  PoseFilter filter(Fine());
  Drive drive;
  double worst_rad = 0;
  int refused_last = 0;
  for (int k = 0; k < 450; ++k) {
    (void)drive.Run(filter, 0.3, 0);
    drive.truth.z() += 300 <= k && k < 350 ? 15 * M_PI / 180 / 50 : 0;
    if (k % 3 == 0) {
      const Status status = filter.Correct(
          {.stamp = drive.now, .pose = drive.truth, .information = Information(1e-3, 2e-3)});
      refused_last = status == Status::kOk ? refused_last : k;
    }
    worst_rad = std::max(worst_rad, std::abs(PoseOf(filter).z() - drive.truth.z()));
  }
  EXPECT_LT(worst_rad, 4 * M_PI / 180);
  EXPECT_LT(refused_last, 325);
  EXPECT_LT((PoseOf(filter) - drive.truth).norm(), 5e-3);
  EXPECT_FALSE(filter.lost());
}

}  // namespace
}  // namespace pipewright
