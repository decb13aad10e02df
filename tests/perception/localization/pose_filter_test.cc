// SPDX-License-Identifier: MIT
#include "perception/localization/pose_filter.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "platform/core/rng.h"
#include "tests/perception/localization/drive.h"

namespace pipewright {
namespace {

using std::chrono::milliseconds;
using test::Drive;
using test::Fine;
using test::Information;
using test::kReport_ms;
using test::kTrack_m;
using test::PoseOf;

TEST(PoseFilter, WithoutFixesGoesWhereTheWheelsTell) {
  PoseFilter filter;
  WheelOdometry wheels;
  Drive drive;
  (void)wheels.Step(Time{}, 0, 0, 0, 0);
  for (int k = 0; k < 500; ++k) {
    const double w = std::sin(0.01 * k);
    ASSERT_EQ(drive.Run(filter, 0.3, w), Status::kOk);
    ASSERT_EQ(wheels.Step(drive.now, 0.3, w, drive.left_m, drive.right_m), Status::kOk);
  }
  const BasePose pose = filter.pose();
  EXPECT_NEAR(pose.x_m, wheels.pose().x_m, 1e-9);
  EXPECT_NEAR(pose.y_m, wheels.pose().y_m, 1e-9);
  EXPECT_NEAR(pose.phi_rad, wheels.pose().phi_rad, 1e-9);
  EXPECT_EQ(filter.fixes(), 0U);
  const BasePose later = filter.Extrapolate(drive.now + milliseconds(10));
  EXPECT_NEAR(later.x_m, wheels.Extrapolate(drive.now + milliseconds(10)).x_m, 1e-9);
}

/// The update at one instant, against the textbook's: the inverse of the sum of informations.
TEST(PoseFilter, AFixAtStandstillIsTheInformationWeightedMean) {
  PoseFilterConfig config = Fine();
  PoseFilter filter(config);
  BasePose start{.x_m = 1, .y_m = 2, .phi_rad = 0.5};
  start.covariance << 4e-4, 1e-4, 5e-5, 1e-4, 3e-4, 2e-5, 5e-5, 2e-5, 1e-4;
  filter.Reset(start);
  PoseFix fix{.stamp = Time{milliseconds(10)}, .pose = {1.01, 1.99, 0.51}};
  fix.information << 5e3, 1e3, 0, 1e3, 8e3, 500, 0, 500, 2e4;
  Drive drive;
  ASSERT_EQ(filter.Step(Time{milliseconds(5)}, 0, 0, 0, 0), Status::kOk);
  ASSERT_EQ(filter.Correct(fix), Status::kOk);

  const Mat<3, 3> of_points = (config.fix.share * fix.information).inverse();
  const Mat<3, 3> of_place = Vector3d(config.fix.sigma_m, config.fix.sigma_m, config.fix.sigma_rad)
                                 .cwiseAbs2()
                                 .asDiagonal();
  Mat<3, 3> across;
  across << 0, -config.fix.tilt_rad, 0, config.fix.tilt_rad, 0, 0, 0, 0, 0;
  const Mat<3, 3> R = of_points + of_place + across * start.covariance * across.transpose();
  const Mat<3, 3> prior = start.covariance.inverse();
  const Mat<3, 3> posterior = (prior + R.inverse()).inverse();
  const Vector3d expected = posterior * (prior * Vector3d(1, 2, 0.5) + R.inverse() * fix.pose);
  EXPECT_LT((PoseOf(filter) - expected).cwiseAbs().maxCoeff(), 1e-8);
  const Mat<3, 3> stated = filter.pose().covariance - of_place;
  EXPECT_LT((stated - posterior).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(PoseFilter, ADirectionWithoutInformationStaysAsItWas) {
  const PoseFilterConfig config = Fine();
  const double shared_m2 = config.fix.sigma_m * config.fix.sigma_m;
  PoseFilter filter(config);
  BasePose start;
  start.covariance = Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
  filter.Reset(start);
  ASSERT_EQ(filter.Step(Time{milliseconds(5)}, 0, 0, 0, 0), Status::kOk);
  // A wall whose normal lies at 30 degrees, far off along it.
  const Vector3d n(std::sqrt(0.75), 0.5, 0);
  const Vector3d along(-0.5, std::sqrt(0.75), 0);
  const PoseFix fix{.stamp = Time{milliseconds(5)},
                    .pose = 0.01 * n + 3 * along,
                    .information = 1e6 / config.fix.share * n * n.transpose()};
  ASSERT_EQ(filter.Correct(fix), Status::kOk);
  EXPECT_NEAR(PoseOf(filter).dot(n), 0.01, 5e-4);
  EXPECT_NEAR(PoseOf(filter).dot(along), 0, 1e-7);
  const Mat<3, 3> P = filter.pose().covariance;
  const double of_tilt_m2 = config.fix.tilt_rad * config.fix.tilt_rad * 1e-4;
  EXPECT_LT(n.dot(P * n), 1e-6 + 2 * shared_m2 + of_tilt_m2);
  EXPECT_NEAR(along.dot(P * along), 1e-4 + shared_m2, 1e-9);
}

/// A wall tells of the way to it alone, however often it is seen, each time by a normal that is a
/// little different: along it the base keeps its place, and how unsure it is.
TEST(PoseFilter, AWallDoesNotTellWhereAlongItTheBaseIs) {
  const auto after_fixes = [](double tilt_rad, std::uint64_t seed) {
    PoseFilterConfig config = Fine();
    config.fix.tilt_rad = tilt_rad;
    PoseFilter filter(config);
    BasePose start;
    start.covariance = Vector3d(2.5e-3, 2.5e-3, 1e-6).asDiagonal();
    filter.Reset(start);
    const double wall_m = 0.02;  // nearer by this than the base takes it to be
    Rng rng(seed);
    Vector3d n = Vector3d::UnitY();
    for (int k = 1; k <= 280; ++k) {
      if (k % 40 == 1) {
        const double tilt = 0.01 * rng.Normal();
        n = {std::sin(tilt), std::cos(tilt), 0};
      }
      const Time now{milliseconds(20 * k)};
      EXPECT_EQ(filter.Step(now, 0, 0, 0, 0), Status::kOk);
      const double off_m = wall_m - PoseOf(filter).y();
      (void)filter.Correct({.stamp = now,
                            .pose = PoseOf(filter) + off_m * n,
                            .information = 4e6 * n * n.transpose()});
    }
    return filter.pose();
  };
  double feigned_m = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const BasePose pose = after_fixes(FixNoiseConfig{}.tilt_rad, seed);
    EXPECT_NEAR(pose.y_m, 0.02, 2e-3) << seed;
    EXPECT_LT(std::abs(pose.x_m), 5e-3) << seed;
    EXPECT_GT(std::sqrt(pose.covariance(0, 0)), 0.02) << seed;
    feigned_m = std::max(feigned_m, 0.05 - std::sqrt(after_fixes(0, seed).covariance(0, 0)));
  }
  EXPECT_GT(feigned_m, 0.03) << "without it the place along the wall is feigned to be known";
}

/// However often it looks at surroundings that it placed while unsure of itself; and a base that
/// came from better ones is no less sure for it.
TEST(PoseFilter, IsNotSurerThanWhatItFindsItselfAmong) {
  const Placement placed{.m2 = 4e-6, .rad2 = 1e-4};
  const auto after_fixes = [&placed](double at_start) {
    PoseFilter filter(Fine());
    BasePose start;
    start.covariance = Vector3d::Constant(at_start).asDiagonal();
    filter.Reset(start);
    for (int k = 1; k <= 200; ++k) {
      const Time now{milliseconds(20 * k)};
      EXPECT_EQ(filter.Step(now, 0, 0, 0, 0), Status::kOk);
      EXPECT_EQ(
          filter.Correct({.stamp = now, .information = Information(1e-4, 1e-4), .placed = placed}),
          Status::kOk);
    }
    return filter.pose().covariance;
  };
  const FixNoiseConfig shared = Fine().fix;
  const Mat<3, 3> came_unsure = after_fixes(1e-2);
  EXPECT_NEAR(came_unsure(0, 0), placed.m2 + shared.sigma_m * shared.sigma_m, 1e-7);
  EXPECT_NEAR(came_unsure(2, 2), placed.rad2 + shared.sigma_rad * shared.sigma_rad, 1e-6);
  const Mat<3, 3> came_sure = after_fixes(1e-7);
  EXPECT_LT(came_sure(0, 0), 1.01e-7 + shared.sigma_m * shared.sigma_m);
  EXPECT_LT(came_sure(2, 2), 1.01e-7 + shared.sigma_rad * shared.sigma_rad);
}

/// Against a filter of two headings, the base's p and that of the surroundings s. It put them there
/// with p's error, then turned: with V then and q of the turn, cov(p, s) = (V + q, V; V, V), and a
/// fix tells y = s - p with variance R.
TEST(PoseFilter, AFixAmongWhatItPlacedItselfCorrectsTheWayItHasMadeSince) {
  const PoseFilterConfig config = Fine();
  PoseFilter filter(config);
  const Placement placed{.m2 = 1e-4, .rad2 = 1e-3};
  BasePose start;
  start.covariance = Variances(placed).asDiagonal();
  filter.Reset(start);
  Drive drive;
  for (int k = 0; k < 50; ++k) {
    ASSERT_EQ(drive.Run(filter, 0, 0.5), Status::kOk);
  }
  const BasePose before = filter.pose();
  const double V = placed.rad2;
  const double q = before.covariance(2, 2) - V;
  ASSERT_GT(q, 0);
  ASSERT_LT(q, V);
  const double y = std::sqrt(q);
  const double of_points = q / 10;
  PoseFix fix{.stamp = drive.now,
              .pose = PoseOf(filter) + Vector3d(0, 0, y),
              .information = Information(1, std::sqrt(of_points)) / config.fix.share,
              .placed = placed};
  ASSERT_EQ(filter.Correct(fix), Status::kOk);

  const double shared = config.fix.sigma_rad * config.fix.sigma_rad;
  const double R = of_points + shared;
  EXPECT_NEAR(filter.pose().phi_rad - before.phi_rad, q / (q + R) * y, 1e-3 * y);
  EXPECT_NEAR(filter.pose().covariance(2, 2) - shared, V + q - q * q / (q + R), 1e-3 * q);
}

TEST(PoseFilter, ALateFixDoesAsOneThatCameInTime) {
  PoseFilter prompt(Fine());
  PoseFilter late(Fine());
  Drive a;
  Drive b;
  PoseFix fix;
  for (int k = 0; k < 100; ++k) {
    (void)a.Run(prompt, 0.2, 0.4);
    (void)b.Run(late, 0.2, 0.4);
    if (k == 80) {
      fix = {.stamp = a.now,
             .pose = a.truth + Vector3d(0.004, -0.003, 0.005),
             .information = Information(1e-3, 1e-3)};
      ASSERT_EQ(prompt.Correct(fix), Status::kOk);
    }
    if (k == 90) {
      ASSERT_EQ(late.Correct(fix), Status::kOk);
    }
  }
  EXPECT_LT((PoseOf(prompt) - PoseOf(late)).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((prompt.pose().covariance - late.pose().covariance).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(PoseFilter, AFixBetweenTwoReportsIsComparedWithThePoseOfItsInstant) {
  PoseFilter filter(Fine());
  Drive drive;
  for (int k = 0; k < 50; ++k) {
    (void)drive.Run(filter, 0.4, 0.6);
  }
  // 7 ms before and 7 ms after the newest report, at the truth: nothing to correct.
  for (const int ms : {-7, 7}) {
    const double dt = 1e-3 * ms;
    const PoseFix fix{
        .stamp = drive.now + milliseconds(ms),
        .pose = drive.truth + Vector3d(0.4 * dt * std::cos(drive.truth.z()),
                                       0.4 * dt * std::sin(drive.truth.z()), 0.6 * dt),
        .information = Information(1e-3, 1e-3)};
    const Vector3d before = PoseOf(filter);
    ASSERT_EQ(filter.Correct(fix), Status::kOk);
    EXPECT_LT((PoseOf(filter) - before).cwiseAbs().maxCoeff(), 2e-5) << ms;
  }
}

TEST(PoseFilter, LearnsHowMuchFartherTheBaseTurnsThanItsWheelsTell) {
  for (const double scale : {0.95, 1.03, 1.06}) {
    PoseFilter filter(Fine());
    Drive drive;
    Rng rng(3);
    for (int k = 0; k < 1500; ++k) {
      (void)drive.Run(filter, 0.1, 0.5 * std::sin(0.02 * k), scale);
      if (k % 3 == 0) {
        const Vector3d noise = 1e-3 * Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
        (void)filter.Correct({.stamp = drive.now,
                              .pose = drive.truth + noise,
                              .information = Information(1e-3, 1e-3)});
      }
    }
    EXPECT_NEAR(filter.yaw_scale_slow(), scale, 0.015);
    EXPECT_NEAR(filter.yaw_scale_fast(), scale, 0.015);
    // Then the lights go out for a turn of 90 degrees, which the wheels tell 5 % wrong.
    for (int k = 0; k < 157; ++k) {
      (void)drive.Run(filter, 0, 0.5, scale);
    }
    EXPECT_NEAR(PoseOf(filter).z(), drive.truth.z(), 0.025);
    EXPECT_GT(std::abs(filter.odometry().pose().phi_rad - drive.truth.z()), 0.04);
  }
}

/// Drives that slip as the configuration says, seen by fixes that are as good as they say: the
/// error squared over the stated covariance must be chi-square of three degrees of freedom.
TEST(PoseFilter, StatesItsErrorsCovariance) {
  PoseFilterConfig config = Fine();
  config.fix.sigma_m = config.fix.sigma_rad = 1e-6;  // what fixes share is no noise of each
  config.fix.tilt_rad = 0;
  config.fix.share = 1;
  config.slip_learning = 0;  // the floor is as slippery as it says,
  config.way_scale_sigma = config.way_scale_walk = 0;
  config.slow_radps = 10;  // and one yaw scale is that of all speeds
  config.fast_radps = 20;
  config.fix.gate = 100;  // of thousands of fixes, one in 7e4 is beyond the usual one by chance
  constexpr int kDrives = 300;
  constexpr int kPeriod = 5;  // reports to a fix
  double sum = 0;
  int samples = 0;
  for (int drive = 0; drive < kDrives; ++drive) {
    Rng rng(1000 + drive);
    PoseFilter filter(config);
    Vector3d truth = Vector3d::Zero();
    double scale = 1 + config.yaw_scale_sigma * rng.Normal();
    double left = 0;
    double right = 0;
    (void)filter.Step(Time{}, 0, 0, 0, 0);
    for (int k = 1; k <= 100; ++k) {
      const double s = 0.006;
      const double t = 0.01 * std::sin(0.1 * k + drive);
      left += s - t * kTrack_m / 2;
      right += s + t * kTrack_m / 2;
      const double s_true = s + config.slip.m * std::sqrt(s) * rng.Normal();
      const double t_true =
          scale * t +
          rng.Normal() * std::sqrt(config.slip.rad_per_m * config.slip.rad_per_m * s +
                                   config.slip.rad_per_rad * config.slip.rad_per_rad * std::abs(t));
      scale += config.yaw_scale_walk * std::sqrt(std::abs(t)) * rng.Normal();
      truth += Vector3d(s_true * std::cos(truth.z() + t_true / 2),
                        s_true * std::sin(truth.z() + t_true / 2), t_true);
      const Time now{milliseconds(kReport_ms * k)};
      (void)filter.Step(now, s / 0.02, t / 0.02, left, right);
      if (k % kPeriod == 0) {
        const Vector3d noise(2e-3 * rng.Normal(), 2e-3 * rng.Normal(), 3e-3 * rng.Normal());
        ASSERT_EQ(
            filter.Correct(
                {.stamp = now, .pose = truth + noise, .information = Information(2e-3, 3e-3)}),
            Status::kOk);
      }
    }
    // Right after a fix, and three steps on its own after another.
    const Vector3d error = PoseOf(filter) - truth;
    sum += error.dot(filter.pose().covariance.inverse() * error);
    ++samples;
  }
  // The mean of 300 chi-squares of 3: 3 +- 2.58 sqrt(6/300) at 99 %.
  EXPECT_NEAR(sum / samples, 3, 0.37);
}

TEST(PoseFilter, GetsLostWhenTheWheelsAloneTellForLong) {
  PoseFilter filter;
  Drive drive;
  int reports = 0;
  while (!filter.lost() && reports < 5000) {
    (void)drive.Run(filter, 0.5, 0);
    ++reports;
  }
  EXPECT_GT(drive.truth.x(), 1.0);
  EXPECT_LT(drive.truth.x(), 20.0);
}

TEST(PoseFilter, RefusesWhatIsNoNumberTooOldOrNotYet) {
  PoseFilter filter;
  Drive drive;
  for (int k = 0; k < 100; ++k) {
    (void)drive.Run(filter, 0.1, 0);
  }
  const Vector3d before = PoseOf(filter);
  PoseFix fix{.stamp = drive.now, .pose = drive.truth, .information = Information(1e-3, 1e-3)};
  PoseFix bad = fix;
  bad.pose.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(filter.Correct(bad), Status::kOutOfRange);
  bad = fix;
  bad.information(2, 2) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(filter.Correct(bad), Status::kOutOfRange);
  bad = fix;
  bad.stamp = drive.now + milliseconds(200);
  EXPECT_EQ(filter.Correct(bad), Status::kOutOfRange);
  bad.stamp = drive.now - milliseconds(kReport_ms * PoseFilter::kSteps);
  EXPECT_EQ(filter.Correct(bad), Status::kStale);
  EXPECT_EQ(PoseOf(filter), before);
  EXPECT_EQ(filter.Correct(fix), Status::kOk);
  EXPECT_EQ(filter.Correct(fix), Status::kStale) << "the same frame twice";
  EXPECT_EQ(filter.Step(drive.now, 0, 0, 0, 0), Status::kStale);
}

TEST(PoseFilter, HeadingsMeetAcrossFullTurns) {
  PoseFilter filter(Fine());
  BasePose start{.phi_rad = 40};
  start.covariance = Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
  filter.Reset(start);
  (void)filter.Step(Time{milliseconds(20)}, 0, 0, 0, 0);
  const double wrapped = std::remainder(40.01, 2 * M_PI);
  ASSERT_EQ(filter.Correct({.stamp = Time{milliseconds(20)},
                            .pose = {0, 0, wrapped},
                            .information = Information(1e-4, 1e-4)}),
            Status::kOk);
  EXPECT_NEAR(PoseOf(filter).z(), 40.01, 1e-3);
}

}  // namespace
}  // namespace pipewright
