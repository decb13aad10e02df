// SPDX-License-Identifier: MIT
#include "hil/report/world_view.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>

namespace pipewright::hil {
namespace {

/// A cube that rolls with its probe above it.
RobotBodies Cube() {
  RobotBodies robot;
  robot.links = 1;
  Body body;
  body.name = "cube";
  body.shape = Shape::Box({0.2, 0.2, 0.2});
  body.X_LG.translation() = Vector3d(0, 0, 0.2);
  robot.bodies.push_back(body);
  robot.forward = [](double x, double y, double yaw, std::span<const double>,
                     RobotBodies::Pose& pose) {
    pose.X_WL.resize(1);
    pose.X_WL[0] = Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ());
    pose.p_WP = pose.X_WL[0] * Vector3d(0, 0, 0.4);
  };
  return robot;
}

/// A box that the probe reaches only the near side of, for a fence keeps the cube at x < 1.
constexpr const char* kWorld = R"(
name = "t"
[workspace]
min_m = [0, 0, 0]
max_m = [2, 1, 1]
[map]
lo_m = [0, 0, -0.1]
hi_m = [2, 1, 1]
[start]
x_m = 0.5
y_m = 0.5
yaw_rad = 0
[[plane]]
name = "floor"
normal = [0, 0, 1]
offset_m = -0.02
ground = true
[[box]]
name = "fence"
center_m = [1.1, 0.5, 0.5]
size_m = [0.1, 1.0, 1.0]
[[cylinder]]
name = "pipe"
from_m = [0.3, 0.8, 0.5]
to_m = [0.3, 0.8, 0.9]
radius_m = 0.1
)";

class WorldViewTest : public testing::Test {
 protected:
  // One folder for all tests: what can be covered is computed once.
  static void SetUpTestSuite() {
    folder_ = std::filesystem::path(testing::TempDir()) / "pipewright_world_view_test";
    std::filesystem::remove_all(folder_);
    setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
  }
  static void TearDownTestSuite() {
    unsetenv("XDG_CACHE_HOME");
    std::filesystem::remove_all(folder_);
  }

  static inline std::filesystem::path folder_;
};

TEST_F(WorldViewTest, TellsCoveredMissedAndOutOfReachApart) {
  const ScenarioResult result = ParseScenario(kWorld, "test", ".");
  ASSERT_TRUE(result.scenario);
  const RobotBodies robot = Cube();
  Truth truth(*result.scenario, robot);
  const auto count = [&truth, &result] {
    std::map<SurfaceState, int> states;
    for (const WorldView::Voxel& v : ViewOf(*result.scenario, &truth).surface) {
      ++states[v.state];
    }
    return states;
  };
  std::map<SurfaceState, int> before = count();
  EXPECT_EQ(before[SurfaceState::kCovered], 0);
  EXPECT_EQ(before[SurfaceState::kMissed], truth.coverage().coverable);
  EXPECT_GT(before[SurfaceState::kOutOfReach], 100);  // behind the fence

  EXPECT_GT(truth.Cover(Vector3d(0.3, 0.5, 0.4)), 0);
  std::map<SurfaceState, int> after = count();
  EXPECT_EQ(after[SurfaceState::kCovered], truth.coverage().covered);
  EXPECT_EQ(after[SurfaceState::kMissed], truth.coverage().coverable - truth.coverage().covered);
}

TEST_F(WorldViewTest, OutlinesLieOnTheirSolids) {
  const ScenarioResult result = ParseScenario(kWorld, "test", ".");
  ASSERT_TRUE(result.scenario);
  const RobotBodies robot = Cube();
  const Truth truth(*result.scenario, robot);
  const WorldView view = ViewOf(*result.scenario, &truth);
  EXPECT_EQ(view.min_m, Vector3d(0, 0, 0));
  EXPECT_EQ(view.max_m, Vector3d(2, 1, 1));
  ASSERT_EQ(view.outlines.size(), 6u + 6u);
  for (const std::vector<Vector3d>& line : view.outlines) {
    for (const Vector3d& p : line) {
      double nearest_m = 1;
      for (const Solid& solid : result.scenario->solids) {
        if (solid.kind != SolidKind::kPlane) {
          nearest_m = std::min(nearest_m, std::abs(Distance(solid, p)));
        }
      }
      EXPECT_LT(nearest_m, 1e-9);
    }
  }
}

}  // namespace
}  // namespace pipewright::hil
