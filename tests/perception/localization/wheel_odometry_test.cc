// SPDX-License-Identifier: MIT
#include "perception/localization/wheel_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

using std::chrono::milliseconds;

constexpr double kTrack = 0.35;
constexpr double kPi = 3.14159265358979323846;

/// How a device turns a real number into its last bit.
using Rounding = double (*)(double value, double unit);

double Nearest(double value, double unit) { return std::floor(value / unit + 0.5) * unit; }
double TowardsZero(double value, double unit) { return std::trunc(value / unit) * unit; }
double Floor(double value, double unit) { return std::floor(value / unit) * unit; }

/// A base that moves exactly, integrated in steps of 1 ms apart from the code under test, and
/// reports as a Tracer does: 1 mm/s, 1 mrad/s, 1 mm, every 20 ms.
struct TrueBase {
  double x = 0;
  double y = 0;
  double phi = 0;
  double left = 0;
  double right = 0;
  double v = 0;
  double w = 0;
  Time now{};

  void Run(double v_mps, double w_radps, int ms) {
    v = v_mps;
    w = w_radps;
    for (int i = 0; i < ms; ++i) {
      const double dt = 1e-3;
      x += v * dt * std::cos(phi + w * dt / 2);
      y += v * dt * std::sin(phi + w * dt / 2);
      phi += w * dt;
      left += (v - w * kTrack / 2) * dt;
      right += (v + w * kTrack / 2) * dt;
      now += milliseconds(1);
    }
  }
  Status Report(WheelOdometry& odometry, Rounding round, double yaw_scale = 1) const {
    return odometry.Step(now, round(v, 1e-3), round(w * yaw_scale, 1e-3), round(left, 1e-3),
                         round(right, 1e-3));
  }
};

double Distance(const BasePose& pose, const TrueBase& base) {
  return std::sqrt(std::pow(pose.x_m - base.x, 2) + std::pow(pose.y_m - base.y, 2));
}

TEST(WheelOdometry, DrivesTheExactArc) {
  WheelOdometry odometry({.quantum_m = 1e-9});
  EXPECT_EQ(odometry.Step(Time{}, 0, 0, 5, -3), Status::kOk);
  // A quarter circle of radius 1 m to the left, told in one step.
  const double turn = kPi / 2;
  EXPECT_EQ(odometry.Step(Time{milliseconds(1000)}, 0, 0, 5 + (1 - kTrack / 2) * turn,
                          -3 + (1 + kTrack / 2) * turn),
            Status::kOk);
  EXPECT_NEAR(odometry.pose().x_m, 1, 1e-8);
  EXPECT_NEAR(odometry.pose().y_m, 1, 1e-8);
  EXPECT_NEAR(odometry.pose().phi_rad, turn, 1e-8);
}

TEST(WheelOdometry, StartsAtThePoseItIsGiven) {
  WheelOdometry odometry;
  BasePose start{.x_m = 1, .y_m = -2, .phi_rad = kPi / 2};
  start.covariance(2, 2) = 0.01;
  odometry.Reset(start);
  (void)odometry.Step(Time{}, 0, 0, 0.7, 0.7);
  (void)odometry.Step(Time{milliseconds(500)}, 0, 0, 1.2, 1.2);
  EXPECT_NEAR(odometry.pose().x_m, 1, 1e-12);
  EXPECT_NEAR(odometry.pose().y_m, -1.5, 1e-3);
  EXPECT_GT(odometry.pose().covariance(0, 0), 0.01 * 0.49 * 0.49);  // heading error over 0.5 m
}

TEST(WheelOdometry, HoldsTheHeadingThroughLongSlowMotionWhateverTheRounding) {
  for (const Rounding round : {Nearest, TowardsZero, Floor}) {
    for (const double v : {0.0004, 0.003, 0.05, -0.0104}) {
      for (const double w : {0.0, 0.0004, -0.0031, 0.05}) {
        TrueBase base;
        WheelOdometry odometry;
        double worst_early = 0;
        double worst_late = 0;
        (void)base.Report(odometry, round);
        for (int k = 0; k < 10000; ++k) {  // 200 s
          base.Run(v, w, 20);
          (void)base.Report(odometry, round);
          double& worst = k < 5000 ? worst_early : worst_late;
          worst = std::max(worst, std::fabs(odometry.pose().phi_rad - base.phi));
        }
        SCOPED_TRACE(testing::Message() << "v " << v << ", w " << w);
        EXPECT_LT(worst_early, 3e-3 / kTrack);
        EXPECT_LT(worst_late, 3e-3 / kTrack);
        const double path = std::fabs(v) * 200;
        EXPECT_LT(Distance(odometry.pose(), base), 2e-3 + path * 3e-3 / kTrack);
      }
    }
  }
}

TEST(WheelOdometry, FollowsRandomDrivesToMillimetresPerMetre) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Rng rng(seed);
    TrueBase base;
    WheelOdometry odometry;
    (void)base.Report(odometry, Nearest);
    double path = 0;
    for (int leg = 0; leg < 60; ++leg) {
      const double v = rng.Uniform(-0.4, 0.4);
      const double w = rng.Uniform(-1, 1);
      for (int k = 0; k < 50; ++k) {
        base.Run(v, w, 20);
        path += std::fabs(v) * 0.02;
        ASSERT_EQ(base.Report(odometry, Nearest), Status::kOk);
      }
      ASSERT_LT(std::fabs(odometry.pose().phi_rad - base.phi), 3e-3 / kTrack);
      ASSERT_LT(Distance(odometry.pose(), base), 2e-3 + 4e-3 * path) << "seed " << seed;
    }
  }
}

TEST(WheelOdometry, IsNotFooledByAYawRateThatReadsLow) {
  TrueBase base;
  WheelOdometry odometry;
  (void)base.Report(odometry, Nearest);
  for (int k = 0; k < 3000; ++k) {
    base.Run(0, 0.3, 20);
    (void)base.Report(odometry, Nearest, 1 / 1.06);
  }
  EXPECT_NEAR(odometry.pose().phi_rad, base.phi, 3e-3 / kTrack);
}

TEST(WheelOdometry, KeepsGoingOverAGapAndOverAResetCounter) {
  WheelOdometry odometry;
  (void)odometry.Step(Time{}, 0.1, 0, 0, 0);
  EXPECT_EQ(odometry.Step(Time{milliseconds(1000)}, 0.1, 0, 0.1, 0.1), Status::kOk);
  EXPECT_NEAR(odometry.pose().x_m, 0.1, 1e-3);
  EXPECT_EQ(odometry.Step(Time{milliseconds(1020)}, 0.1, 0, 50, 50), Status::kFault);
  EXPECT_EQ(odometry.jumps(), 1u);
  EXPECT_NEAR(odometry.pose().x_m, 0.102, 1e-3);
  EXPECT_EQ(odometry.Step(Time{milliseconds(1040)}, 0.1, 0, 50.002, 50.002), Status::kOk);
  EXPECT_NEAR(odometry.pose().x_m, 0.104, 1e-3);
}

TEST(WheelOdometry, RefusesWhatIsNotANumberOrNotNew) {
  WheelOdometry odometry;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  (void)odometry.Step(Time{milliseconds(20)}, 0, 0, 0, 0);
  EXPECT_EQ(odometry.Step(Time{milliseconds(40)}, nan, 0, 0, 0), Status::kOutOfRange);
  EXPECT_EQ(odometry.Step(Time{milliseconds(40)}, 0, inf, 0, 0), Status::kOutOfRange);
  EXPECT_EQ(odometry.Step(Time{milliseconds(40)}, 0, 0, -inf, 0), Status::kOutOfRange);
  EXPECT_EQ(odometry.Step(Time{milliseconds(40)}, 0, 0, 0, nan), Status::kOutOfRange);
  EXPECT_EQ(odometry.Step(Time{milliseconds(20)}, 0, 0, 1, 1), Status::kStale);
  EXPECT_EQ(odometry.pose().x_m, 0);
}

TEST(WheelOdometry, ExtrapolatesAlongTheTwistButNotFar) {
  WheelOdometry odometry;
  (void)odometry.Step(Time{}, 0.2, 0.5, 0, 0);
  const BasePose soon = odometry.Extrapolate(Time{milliseconds(10)});
  EXPECT_NEAR(soon.x_m, 0.002, 1e-7);
  EXPECT_NEAR(soon.phi_rad, 0.005, 1e-12);
  EXPECT_EQ(soon.stamp, Time{milliseconds(10)});
  EXPECT_NEAR(odometry.Extrapolate(Time{milliseconds(9000)}).phi_rad, 0.05, 1e-12);
  EXPECT_EQ(odometry.Extrapolate(Time{milliseconds(-10)}).phi_rad, 0);
}

TEST(WheelOdometry, CovarianceCoversTheSpreadOfSlippingDrives) {
  // Each step's forward and turning motion slips as the configuration says; the spread of 400
  // drives along one path must match the covariance that is reported for it.
  const WheelOdometryConfig config;
  Rng rng(5);
  constexpr int kDrives = 400;
  Mat<3, 3> spread = Mat<3, 3>::Zero();
  Mat<3, 3> reported = Mat<3, 3>::Zero();
  for (int drive = 0; drive < kDrives; ++drive) {
    WheelOdometry odometry(config);
    double left = 0;
    double right = 0;
    double x = 0;
    double y = 0;
    double phi = 0;
    (void)odometry.Step(Time{}, 0, 0, 0, 0);
    for (int k = 1; k <= 200; ++k) {
      const double ds = 0.01;
      const double dphi = 0.01;
      left += ds - dphi * kTrack / 2;
      right += ds + dphi * kTrack / 2;
      (void)odometry.Step(Time{milliseconds(20 * k)}, 0.5, 0.5, left, right);
      const double s = ds + rng.Normal() * config.slip.m * std::sqrt(ds);
      const double t =
          dphi + rng.Normal() * std::sqrt(config.slip.rad_per_m * config.slip.rad_per_m * ds +
                                          config.slip.rad_per_rad * config.slip.rad_per_rad * dphi);
      x += s * std::cos(phi + t / 2);
      y += s * std::sin(phi + t / 2);
      phi += t;
    }
    const Vector3d error(x - odometry.pose().x_m, y - odometry.pose().y_m,
                         phi - odometry.pose().phi_rad);
    spread += error * error.transpose() / kDrives;
    reported = odometry.pose().covariance;
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(reported(i, i), 0.8 * spread(i, i)) << i;
    EXPECT_LT(reported(i, i), 1.3 * spread(i, i)) << i;
  }
  EXPECT_LT((reported - reported.transpose()).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(WheelOdometry, CovarianceSinceIsThatOfAnOdometryThatBeganThere) {
  WheelOdometry whole;
  WheelOdometry part;
  BasePose then;
  double left = 0;
  double right = 0;
  (void)whole.Step(Time{}, 0, 0, 0, 0);
  for (int k = 1; k <= 300; ++k) {
    left += 0.01;
    right += k < 200 ? 0.013 : 0.006;
    (void)whole.Step(Time{milliseconds(20 * k)}, 0.5, 0.3, left, right);
    if (k == 150) {
      then = whole.pose();
      BasePose start = then;
      start.covariance.setZero();
      part.Reset(start);
    }
    if (k >= 150) {
      (void)part.Step(Time{milliseconds(20 * k)}, 0.5, 0.3, left, right);
    }
  }
  EXPECT_EQ(whole.CovarianceSince(whole.pose()).diagonal().minCoeff() > 0, true);
  const Mat<3, 3> since = whole.CovarianceSince(then);
  const Mat<3, 3> difference = since - part.pose().covariance;
  // Besides slip, the rounding of `then` counts: 0.3 mm, and what its heading makes of the way.
  constexpr double kRounding_rad = 1e-3 / 0.35 * 0.42;
  const double way_m = std::hypot(whole.pose().x_m - then.x_m, whole.pose().y_m - then.y_m);
  EXPECT_LT(difference(2, 2), kRounding_rad * kRounding_rad);
  EXPECT_GT(difference.diagonal().minCoeff(), 0);
  EXPECT_LT(difference.topLeftCorner(2, 2).trace(), 2e-7 + std::pow(way_m * kRounding_rad, 2));
  EXPECT_GT(whole.pose().covariance(0, 0), 1.5 * since(0, 0));  // the test can tell
}

/// Things placed in W by the pose of then: what matters is where the robot is among them.
TEST(WheelOdometry, CovarianceSinceCoversTheSpreadOfWhatSlippedSince) {
  const WheelOdometryConfig config;
  Rng rng(6);
  constexpr int kDrives = 400;
  Mat<3, 3> spread = Mat<3, 3>::Zero();
  Mat<3, 3> reported = Mat<3, 3>::Zero();
  for (int drive = 0; drive < kDrives; ++drive) {
    WheelOdometry odometry(config);
    BasePose then;
    double left = 0;
    double right = 0;
    Vector3d truth = Vector3d::Zero();
    Vector3d true_then = Vector3d::Zero();
    (void)odometry.Step(Time{}, 0, 0, 0, 0);
    for (int k = 1; k <= 300; ++k) {
      const double ds = 0.01;
      const double dphi = k < 150 ? 0.01 : -0.005;
      left += ds - dphi * kTrack / 2;
      right += ds + dphi * kTrack / 2;
      (void)odometry.Step(Time{milliseconds(20 * k)}, 0.5, 50 * dphi, left, right);
      const double turn_var = config.slip.rad_per_m * config.slip.rad_per_m * ds +
                              config.slip.rad_per_rad * config.slip.rad_per_rad * std::abs(dphi);
      const double s = ds + rng.Normal() * config.slip.m * std::sqrt(ds);
      const double t = dphi + rng.Normal() * std::sqrt(turn_var);
      truth += Vector3d(s * std::cos(truth.z() + t / 2), s * std::sin(truth.z() + t / 2), t);
      if (k == 200) {
        then = odometry.pose();
        true_then = truth;
      }
    }
    // The true world turned and moved so that it fits the estimate at that time.
    const double turn = then.phi_rad - true_then.z();
    const Eigen::Rotation2Dd R(turn);
    const Eigen::Vector2d place =
        Eigen::Vector2d(then.x_m, then.y_m) + R * (truth - true_then).head<2>();
    const Vector3d error(place.x() - odometry.pose().x_m, place.y() - odometry.pose().y_m,
                         truth.z() + turn - odometry.pose().phi_rad);
    spread += error * error.transpose() / kDrives;
    reported = odometry.CovarianceSince(then);
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(reported(i, i), 0.8 * spread(i, i)) << i;
    EXPECT_LT(reported(i, i), 1.3 * spread(i, i)) << i;
  }
}

}  // namespace
}  // namespace pipewright
