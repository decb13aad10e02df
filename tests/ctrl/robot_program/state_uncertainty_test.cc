// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/state_uncertainty.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

using std::chrono::milliseconds;

/// As if no scan had ever corrected the pose.
BaseBelief ByWheels(const WheelOdometry& odometry) {
  const BasePose& pose = odometry.pose();
  return {.by_wheels = pose,
          .phi_rad = pose.phi_rad,
          .covariance = pose.covariance + 1e3 * Matrix3d::Identity()};
}

/// A base that drives ahead at 0.5 m/s and reports every 20 ms.
struct Drive {
  void To(int report) {
    for (; k <= report; ++k) {
      const double way_m = 0.01 * k;
      EXPECT_EQ(odometry.Step(Time{milliseconds(20 * k)}, 0.5, 0, way_m, way_m), Status::kOk);
      uncertainty.Add(ByWheels(odometry));
      poses.push_back(odometry.pose());
    }
  }
  int k = 0;
  WheelOdometry odometry;
  StateUncertainty uncertainty{3e-4};
  std::vector<BasePose> poses;
};

Scene SceneAt(Time stamp) {
  Scene scene;
  scene.stamp = stamp;
  return scene;
}

TEST(StateUncertainty, IsOfWhatWasDrivenSinceTheScenesStamp) {
  Drive drive;
  drive.To(50);
  drive.uncertainty.Since(SceneAt(Time{milliseconds(20 * 40 + 7)}), drive.odometry);
  drive.To(60);
  const StateCovariance& now =
      drive.uncertainty.Since(SceneAt(Time{milliseconds(20 * 40 + 7)}), drive.odometry);
  EXPECT_EQ(now.base, drive.odometry.CovarianceSince(drive.poses[40]));
  // 0.2 m ahead: the slip's 1 cm at 1 m, with the root.
  EXPECT_NEAR(now.base(0, 0), 1e-4 * 0.2, 1e-6);
  EXPECT_LT(5 * now.base(0, 0), drive.odometry.pose().covariance(0, 0) * 2);
  EXPECT_NEAR(now.joint_rad2(3), 9e-8, 1e-15);
}

TEST(StateUncertainty, GrowsUntilANewSceneComesHoweverLongThatTakes) {
  Drive drive;
  drive.To(10);
  const Time stamp{milliseconds(20 * 10)};
  double last = drive.uncertainty.Since(SceneAt(stamp), drive.odometry).base(0, 0);
  for (int report = 20; report <= 400; report += 10) {  // far longer than poses are held
    drive.To(report);
    const double now = drive.uncertainty.Since(SceneAt(stamp), drive.odometry).base(0, 0);
    EXPECT_NEAR(now - last, 1e-4 * 0.1, 1e-6);
    last = now;
  }
  const Time newer{milliseconds(20 * 395)};
  EXPECT_LT(drive.uncertainty.Since(SceneAt(newer), drive.odometry).base(0, 0), 0.1 * last);
}

TEST(StateUncertainty, OfASceneThatIsTooOldTheOldestPoseCounts) {
  Drive drive;
  drive.To(200);
  const StateCovariance& now = drive.uncertainty.Since(Scene{}, drive.odometry);
  EXPECT_EQ(now.base, drive.odometry.CovarianceSince(drive.poses[200 - 63]));
}

/// A scene of that stamp with one plane and one pipe, last seen when they were.
Scene SceneOf(Time stamp, Time plane_seen, Time pipe_seen) {
  Scene scene = SceneAt(stamp);
  PlaneEstimate plane;
  plane.id = 7;
  plane.last_seen = plane_seen;
  EXPECT_TRUE(scene.planes.push_back(plane));
  PipeEstimate pipe;
  pipe.id = 9;
  pipe.last_seen = pipe_seen;
  EXPECT_TRUE(scene.pipes.push_back(pipe));
  return scene;
}

TEST(StateUncertainty, OfEachPrimitiveIsWhatWasDrivenSinceItWasLastSeen) {
  Drive drive;
  const auto at = [](int report) { return Time{milliseconds(20 * report)}; };
  for (int report = 10; report <= 500; report += 10) {  // far longer than poses are held
    drive.To(report);
    const int plane_seen = report <= 100 ? report : 100;
    const int pipe_seen =
        report <= 300 ? std::min(report, 20) : 300;  // out of view, seen again, out of view
    const StateCovariance& now =
        drive.uncertainty.Since(SceneOf(at(report), at(plane_seen), at(pipe_seen)), drive.odometry);
    EXPECT_EQ(now.base, drive.odometry.CovarianceSince(drive.odometry.pose()));
    EXPECT_EQ(now.ToPlane(0), drive.odometry.CovarianceSince(drive.poses[plane_seen])) << report;
    if (report <= 300 && report >= 20) {
      EXPECT_EQ(now.ToPipe(0), drive.odometry.CovarianceSince(drive.poses[20])) << report;
    }
  }
}

/// What the odometry holds while the wheels slip as it is told they do. The primitive is placed in
/// W by the pose that is held when it is seen, so what is wrong later is the pose relative to that.
TEST(StateUncertainty, IsTheSpreadOfWhatTheWheelsSlippedSince) {
  constexpr int kReports = 250;  // 5 s
  constexpr int kPlaneSeen = 40;
  constexpr int kPipeSeen = 170;
  constexpr int kDraws = 4000;
  const WheelOdometryConfig config;
  WheelOdometry odometry(config);
  StateUncertainty uncertainty(0);
  std::vector<BasePose> held;
  double left_m = 0;
  double right_m = 0;
  const StateCovariance* now = nullptr;
  for (int k = 0; k <= kReports; ++k) {
    const double turn_radps = k < 120 ? 0.5 : -0.3;
    ASSERT_EQ(odometry.Step(Time{milliseconds(20 * k)}, 0.4, turn_radps, left_m, right_m),
              Status::kOk);
    left_m += 0.02 * (0.4 - turn_radps * config.track_m / 2);
    right_m += 0.02 * (0.4 + turn_radps * config.track_m / 2);
    uncertainty.Add(ByWheels(odometry));
    held.push_back(odometry.pose());
    const Time stamp{milliseconds(20 * k)};
    now = &uncertainty.Since(SceneOf(stamp, std::min(stamp, Time{milliseconds(20 * kPlaneSeen)}),
                                     std::min(stamp, Time{milliseconds(20 * kPipeSeen)})),
                             odometry);
  }
  for (const bool of_plane : {true, false}) {
    const int seen = of_plane ? kPlaneSeen : kPipeSeen;
    Rng rng(1, seen);
    Matrix3d sum = Matrix3d::Zero();
    for (int draw = 0; draw < kDraws; ++draw) {
      double x = held[seen].x_m;  // the way as it was, from the pose that counts as known
      double y = held[seen].y_m;
      double phi = held[seen].phi_rad;
      for (int k = seen; k < kReports; ++k) {
        const double step =
            std::hypot(held[k + 1].x_m - held[k].x_m, held[k + 1].y_m - held[k].y_m);
        const double turn = held[k + 1].phi_rad - held[k].phi_rad;
        const double forward = step + config.slip.m * std::sqrt(step) * rng.Normal();
        const double turned =
            turn + rng.Normal() * std::sqrt(std::pow(config.slip.rad_per_m, 2) * step +
                                            std::pow(config.slip.rad_per_rad, 2) * std::abs(turn));
        x += forward * std::cos(phi + turned / 2);
        y += forward * std::sin(phi + turned / 2);
        phi += turned;
      }
      const Vector3d off{x - held[kReports].x_m, y - held[kReports].y_m,
                         phi - held[kReports].phi_rad};
      sum += off * off.transpose() / kDraws;
    }
    const Matrix3d& stated = of_plane ? now->ToPlane(0) : now->ToPipe(0);
    for (int i = 0; i < 3; ++i) {  // the rounding of the wheels' counters comes on top
      EXPECT_NEAR(std::sqrt(stated(i, i) / sum(i, i)), 1, 0.06) << seen << ", " << i;
      for (int j = 0; j < i; ++j) {
        const double scale = std::sqrt(sum(i, i) * sum(j, j));
        EXPECT_NEAR(stated(i, j) / scale, sum(i, j) / scale, 0.08) << seen << ", " << i << j;
      }
    }
    EXPECT_GT(sum(1, 1), 4 * now->base(1, 1));  // since the scene's stamp it would be far less
  }
}

TEST(StateUncertainty, BeforeTheFirstReportOnlyTheJointsAreUnsure) {
  StateUncertainty uncertainty(1e-3);
  const WheelOdometry odometry;
  EXPECT_TRUE(uncertainty.Since(Scene{}, odometry).base.isZero(0));
  EXPECT_NEAR(uncertainty.Since(Scene{}, odometry).joint_rad2(0), 1e-6, 1e-15);
}

/// The pipe out of view since the first report is as far off as the corrected pose may be, then and
/// now, and not as the wheels have slipped since.
TEST(StateUncertainty, DoesNotGrowBeyondThatOfThePoseWhileScansCorrectIt) {
  Drive drive;
  const double corrected_m2 = 4e-6;
  const Matrix3d held = corrected_m2 * Matrix3d::Identity();
  StateUncertainty uncertainty(0);
  Time now{};
  for (int report = 0; report <= 400; ++report) {
    drive.To(report);
    now = Time{milliseconds(20 * report)};
    const BasePose& pose = drive.odometry.pose();
    uncertainty.Add({.by_wheels = pose, .phi_rad = pose.phi_rad, .covariance = held});
    (void)uncertainty.Since(SceneOf(now, now, Time{}), drive.odometry);
  }
  const StateCovariance& after = uncertainty.Since(SceneOf(now, now, Time{}), drive.odometry);
  EXPECT_EQ(after.ToPipe(0), 2 * held);
  EXPECT_EQ(after.ToPlane(0), drive.odometry.CovarianceSince(drive.odometry.pose()));
}

/// With the heading that the wheels tell a quarter turn behind, what they slip ahead is across.
TEST(StateUncertainty, TurnsTheWheelsCovarianceIntoTheWorld) {
  Drive drive;
  StateUncertainty uncertainty(0);
  for (int report = 0; report <= 50; ++report) {
    drive.To(report);
    BaseBelief belief = ByWheels(drive.odometry);
    belief.phi_rad += std::numbers::pi / 2;
    uncertainty.Add(belief);
  }
  const Matrix3d by_wheels = drive.odometry.CovarianceSince(drive.poses[10]);
  const Matrix3d in_world =
      uncertainty.Since(SceneAt(Time{milliseconds(200)}), drive.odometry).base;
  ASSERT_GT(by_wheels(0, 0), 2 * by_wheels(1, 1));
  EXPECT_NEAR(in_world(1, 1), by_wheels(0, 0), 1e-12);
  EXPECT_NEAR(in_world(0, 0), by_wheels(1, 1), 1e-12);
  EXPECT_NEAR(in_world(2, 2), by_wheels(2, 2), 1e-12);
}

}  // namespace
}  // namespace pipewright
