// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/state_uncertainty.h"

#include <gtest/gtest.h>

#include <vector>

namespace pipewright {
namespace {

using std::chrono::milliseconds;

/// A base that drives ahead at 0.5 m/s and reports every 20 ms.
struct Drive {
  void To(int report) {
    for (; k <= report; ++k) {
      const double way_m = 0.01 * k;
      EXPECT_EQ(odometry.Step(Time{milliseconds(20 * k)}, 0.5, 0, way_m, way_m), Status::kOk);
      uncertainty.Add(odometry.pose());
      poses.push_back(odometry.pose());
    }
  }
  int k = 0;
  WheelOdometry odometry;
  StateUncertainty uncertainty{3e-4};
  std::vector<BasePose> poses;
};

TEST(StateUncertainty, IsOfWhatWasDrivenSinceTheScenesStamp) {
  Drive drive;
  drive.To(50);
  drive.uncertainty.Since(Time{milliseconds(20 * 40 + 7)}, drive.odometry);
  drive.To(60);
  const StateCovariance& now =
      drive.uncertainty.Since(Time{milliseconds(20 * 40 + 7)}, drive.odometry);
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
  double last = drive.uncertainty.Since(stamp, drive.odometry).base(0, 0);
  for (int report = 20; report <= 400; report += 10) {  // far longer than poses are held
    drive.To(report);
    const double now = drive.uncertainty.Since(stamp, drive.odometry).base(0, 0);
    EXPECT_NEAR(now - last, 1e-4 * 0.1, 1e-6);
    last = now;
  }
  const Time newer{milliseconds(20 * 395)};
  EXPECT_LT(drive.uncertainty.Since(newer, drive.odometry).base(0, 0), 0.1 * last);
}

TEST(StateUncertainty, OfASceneThatIsTooOldTheOldestPoseCounts) {
  Drive drive;
  drive.To(200);
  const StateCovariance& now = drive.uncertainty.Since(Time{}, drive.odometry);
  EXPECT_EQ(now.base, drive.odometry.CovarianceSince(drive.poses[200 - 63]));
}

TEST(StateUncertainty, BeforeTheFirstReportOnlyTheJointsAreUnsure) {
  StateUncertainty uncertainty(1e-3);
  const WheelOdometry odometry;
  EXPECT_TRUE(uncertainty.Since(Time{}, odometry).base.isZero(0));
  EXPECT_NEAR(uncertainty.Since(Time{}, odometry).joint_rad2(0), 1e-6, 1e-15);
}

}  // namespace
}  // namespace pipewright
