// SPDX-License-Identifier: MIT
#include "hil/world/coverable.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "hil/plant/robot_description.h"
#include "hil/world/truth.h"

namespace pipewright::hil {
namespace {

/// A vehicle of 0.2 x 0.2 m with a mast: the probe is 0.35 m above its centre.
RobotBodies MastVehicle() {
  RobotBodies robot;
  robot.links = 1;
  Body body;
  body.name = "vehicle";
  body.shape = Shape::Box({0.2, 0.2, 0.5});
  body.X_LG.translation() = Vector3d(0, 0, 0.3);
  robot.bodies.push_back(body);
  robot.forward = [](double x, double y, double yaw, std::span<const double>,
                     RobotBodies::Pose& pose) {
    pose.X_WL.resize(1);
    pose.X_WL[0] = Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ());
    pose.p_WP = pose.X_WL[0] * Vector3d(0, 0, 0.35);
  };
  return robot;
}

/// A room of 2 x 2 m whose far half, x > 1, is closed off by a fence that ends below z = 0.4.
Scenario TwoRooms(const std::string& more = "") {
  const ScenarioResult result = ParseScenario(
      "name='t'\n[workspace]\nmin_m=[0,0,0]\nmax_m=[2,2,1]\n"
      "[map]\nlo_m=[0,0,-0.1]\nhi_m=[2,2,1]\n"
      "[start]\nx_m=0.5\ny_m=1\nyaw_rad=0\n"
      "[[plane]]\nname='floor'\nnormal=[0,0,1]\noffset_m=0.02\nground=true\n"
      "[[box]]\nname='fence'\ncenter_m=[1.02,1,0.2]\nsize_m=[0.03,3,0.36]\n" +
          more,
      "t", "");
  EXPECT_TRUE(result.scenario) << result.errors[0];
  return *result.scenario;
}

struct Probed {
  explicit Probed(const Scenario& scenario)
      : surface(SampleSurface(scenario)), rays(scenario.solids), probe(surface, rays, 0.6) {}
  SurfaceVoxels surface;
  RayScene rays;
  CoverageProbe probe;
};

constexpr CoverableConfig kFew{
    .min_configurations = 800, .max_configurations = 2000, .saturated_after = 300};

// Oracle: the probe's place is known, P = (x, y, 0.35) with x, y in [0.1, 0.905] x [0, 2].
TEST(ComputeCoverable, IsWhatTheProbeReachesOnThisSideOfTheFence) {
  const Scenario scenario = TwoRooms();
  const Probed p(scenario);
  const CoverableSet set = ComputeCoverable(scenario, MastVehicle(), p.probe, kFew);
  EXPECT_TRUE(set.saturated);
  int on_floor = 0;
  for (std::size_t i = 0; i < p.surface.voxels.size(); ++i) {
    const auto& index = p.surface.voxels[i].index;
    const double x = (index[0] + 0.5) * 0.05;
    if (index[2] == 0 && x < 0.95) {
      EXPECT_EQ(set.coverable[i], 1) << x;
      ++on_floor;
    } else if (index[2] == 0 && x > 1.1) {
      // The probe's centre never rises above the fence's top, z = 0.38.
      EXPECT_EQ(set.coverable[i], 0) << x;
    }
  }
  EXPECT_GT(on_floor, 700);
}

TEST(ComputeCoverable, IsNothingForARobotThatStandsInAWall) {
  const Scenario scenario =
      TwoRooms("[[box]]\nname='block'\ncenter_m=[0.5,1,0.3]\nsize_m=[0.3,0.3,0.3]\n");
  const Probed p(scenario);
  const CoverableSet set = ComputeCoverable(scenario, MastVehicle(), p.probe, kFew);
  EXPECT_EQ(set.count, 0);
  EXPECT_EQ(set.configurations, 0);
}

TEST(ComputeCoverable, IsTheSameTwice) {
  const Scenario scenario = TwoRooms();
  const Probed p(scenario);
  const CoverableSet a = ComputeCoverable(scenario, MastVehicle(), p.probe, kFew);
  const CoverableSet b = ComputeCoverable(scenario, MastVehicle(), p.probe, kFew);
  EXPECT_EQ(a.coverable, b.coverable);
  EXPECT_EQ(a.configurations, b.configurations);
}

class CacheFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / "pipewright_cache_test";
    std::filesystem::remove_all(folder_);
    setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
  }
  void TearDown() override {
    std::filesystem::remove_all(folder_);
    unsetenv("XDG_CACHE_HOME");
  }
  std::filesystem::path OnlyFile() const {
    return std::filesystem::directory_iterator(folder_ / "pipewright")->path();
  }
  std::filesystem::path folder_;
};

TEST_F(CacheFolder, GivesBackWhatWasComputed) {
  const Scenario scenario = TwoRooms();
  const Probed p(scenario);
  const CoverableSet computed = CachedCoverable(scenario, MastVehicle(), p.probe, kFew);
  const CoverableSet read = CachedCoverable(scenario, MastVehicle(), p.probe, kFew);
  EXPECT_FALSE(computed.from_cache);
  EXPECT_TRUE(read.from_cache);
  EXPECT_EQ(read.coverable, computed.coverable);
  EXPECT_EQ(read.count, computed.count);
  EXPECT_EQ(read.configurations, computed.configurations);
  EXPECT_EQ(read.saturated, computed.saturated);
}

TEST_F(CacheFolder, IsNotTakenForAnotherWorldOrRobot) {
  const Scenario scenario = TwoRooms();
  const Probed p(scenario);
  EXPECT_FALSE(CachedCoverable(scenario, MastVehicle(), p.probe, kFew).from_cache);
  const Scenario other = TwoRooms(
      "[[cylinder]]\nname='c'\nfrom_m=[0.3,0,0.9]\nto_m=[0.3,2,0.9]\n"
      "radius_m=0.05\n");
  const Probed q(other);
  EXPECT_FALSE(CachedCoverable(other, MastVehicle(), q.probe, kFew).from_cache);
  RobotBodies wide = MastVehicle();
  wide.bodies[0].shape.size_m.x() = 0.3;
  EXPECT_FALSE(CachedCoverable(scenario, wide, p.probe, kFew).from_cache);
}

TEST_F(CacheFolder, ThatIsDamagedIsComputedAnew) {
  const Scenario scenario = TwoRooms();
  const Probed p(scenario);
  const CoverableSet computed = CachedCoverable(scenario, MastVehicle(), p.probe, kFew);
  {
    std::fstream file(OnlyFile(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(100);
    file.put('\x01').put('\x00').put('\x01');
    file.put('\x7F');
  }
  const CoverableSet again = CachedCoverable(scenario, MastVehicle(), p.probe, kFew);
  EXPECT_FALSE(again.from_cache);
  EXPECT_EQ(again.coverable, computed.coverable);
  std::filesystem::resize_file(OnlyFile(), 10);
  EXPECT_FALSE(CachedCoverable(scenario, MastVehicle(), p.probe, kFew).from_cache);
}

TEST_F(CacheFolder, ThatCannotBeWrittenIsNoError) {
  std::ofstream(folder_) << "a file where the folder should be";
  const Scenario scenario = TwoRooms();
  const Probed p(scenario);
  EXPECT_GT(CachedCoverable(scenario, MastVehicle(), p.probe, kFew).count, 0);
}

TEST_F(CacheFolder, TruthTellsCoverageAndClearancesOfARun) {
  const Scenario scenario = TwoRooms();
  const RobotBodies robot = MastVehicle();
  Truth truth(scenario, robot);
  EXPECT_EQ(truth.coverage().covered, 0);
  EXPECT_GT(truth.coverage().coverable, 100);
  EXPECT_EQ(truth.coverage().ratio, 0);
  RobotBodies::Pose pose;
  int added = 0;
  for (const double y : {0.5, 1.0, 1.5}) {
    robot.forward(0.6, y, 0, {}, pose);
    truth.Measure(pose.X_WL);
    added += truth.Cover(pose.p_WP);
  }
  EXPECT_EQ(truth.coverage().covered, added);
  EXPECT_GT(truth.coverage().ratio, 0);
  EXPECT_LE(truth.coverage().ratio, 1);
  EXPECT_NEAR(truth.min_plane_m(), 1.005 - 0.7, 1e-8);
  EXPECT_TRUE(std::isinf(truth.min_pipe_m()));
  EXPECT_EQ(truth.contacts(), 0);
  robot.forward(0.95, 1, 0, {}, pose);
  EXPECT_EQ(truth.Measure(pose.X_WL).contacts, 1);
  EXPECT_EQ(truth.contacts(), 1);
  EXPECT_EQ(truth.min_plane_m(), 0);
}

TEST_F(CacheFolder, ShippedScenariosCanBeCoveredWhole) {
  const RobotBodies robot = RobotBodiesOf(TracerUf7Description());
  for (const ShippedToml& shipped : ShippedScenarios()) {
    const Scenario scenario = *LoadScenario(std::string(shipped.name)).scenario;
    const Truth truth(scenario, robot);
    EXPECT_EQ(truth.coverage().coverable, truth.coverage().surface) << shipped.name;
    EXPECT_TRUE(truth.coverable().saturated);
  }
}

}  // namespace
}  // namespace pipewright::hil
