// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/mapping_task.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "platform/robot/shapes.h"
#include "tests/ctrl/robot_program/small_world.h"
#include "tests/perception/map/octomap_oracle.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using std::chrono::milliseconds;
using test::HomeAtOrigin;
using test::Moving;
using test::NoAllocScope;
using test::SmallMap;

using Body = Kinematics<kArmJoints>;

/// The emulated camera in the small world, with the real robot's bodies in view.
struct Eye {
  void Shoot(const Configuration& q, DepthFrame& frame) {
    const hil::Plant plant(hil::TracerUf7Description(), {q(0), q(1), q(2)}, q.tail<kArmJoints>());
    std::vector<Isometry3d> links;
    for (int i = 0; i < plant.link_count(); ++i) {
      links.push_back(plant.X_WL(i));
    }
    camera.Render(plant.X_WS(), links, frame);
  }

  hil::RobotBodies robot = hil::RobotBodiesOf(hil::TracerUf7Description());
  hil::DepthCamera camera{{}, test::WallAndPipe(), robot, 3};
};

MappingConfig Config() {
  MappingConfig config;
  config.map = SmallMap();
  return config;
}

/// The points of a frame, in W, as MakeCloud gives them with the robot at q.
test::Scan ScanOf(const DepthFrame& frame, const Configuration& q, const MappingConfig& config) {
  const Body body(TracerUf7(), q);
  std::vector<SelfBox> boxes;
  for (const BodyShape& shape : TracerUf7Shapes().shapes) {
    boxes.push_back({body.X_WL(shape.body) * shape.X_LG, shape.half_m});
  }
  const auto cloud = std::make_unique<Cloud>();
  CloudCounts counts;
  EXPECT_EQ(MakeCloud(frame, body.X_WS(), boxes, config.cloud, *cloud, counts), Status::kOk);
  const Eigen::Isometry3f X_WS = body.X_WS().cast<float>();
  test::Scan scan{
      .origin_W = X_WS.translation(), .max_range_m = config.max_range_m, .points_W = {}};
  for (int i = 0; i < cloud->size(); ++i) {
    if (cloud->valid[i] != 0) {
      scan.points_W.push_back(X_WS * cloud->p_SQ[i]);
    }
  }
  return scan;
}

/// Where the robot is in the n-th frame: it sways, so that frames differ and the pose matters.
Configuration Posture(int n) {
  Configuration q = HomeAtOrigin();
  q(0) += 0.03 * n;
  q(2) += 0.05 * n;
  q(3) += 0.2 * n - 0.4;
  q(8) += 0.15 * n - 0.3;
  return q;
}

TEST(MappingTask, BuildsTheMapThatOctomapBuildsFromTheSameFrames) {
  const MappingConfig config = Config();
  const auto task = std::make_unique<MappingTask>(config, TracerUf7());
  task->Start(HomeAtOrigin());
  Eye eye;
  octomap::OcTree tree(config.map.width_m);
  const auto frame = std::make_unique<DepthFrame>();
  int points = 0;
  for (int n = 0; n < 5; ++n) {
    const Configuration q = Posture(n);
    eye.Shoot(q, *frame);
    const test::Scan scan = ScanOf(*frame, q, config);
    points += static_cast<int>(scan.points_W.size());
    test::InsertOctomap(&tree, scan);
    const StateHistory history = Moving(q, q, frame->stamp - milliseconds(50));
    ASSERT_EQ(task->Step(*frame, {.states = history}), Status::kOk);
    ASSERT_EQ(test::Difference(task->map(), tree), "") << "after frame " << n;
  }
  EXPECT_GT(points, 10'000);
  EXPECT_GT(task->map().counts().occupied, 100);
  EXPECT_EQ(task->counters().frames, 5U);
  EXPECT_EQ(task->counters().without_pose + task->counters().refused, 0U);
  EXPECT_EQ(task->map().updates_refused(), 0);
}

TEST(MappingTask, PlacesAFrameWhereTheRobotWasInTheMiddleOfItsExposure) {
  const MappingConfig config = Config();
  const auto task = std::make_unique<MappingTask>(config, TracerUf7());
  Eye eye;
  const auto frame = std::make_unique<DepthFrame>();
  // Both ends of the motion are far from where the picture is taken.
  Configuration from = HomeAtOrigin();
  Configuration to = HomeAtOrigin();
  from(0) -= 0.2;
  from(3) -= 0.3;
  to(0) += 0.2;
  to(3) += 0.3;
  eye.Shoot(HomeAtOrigin(), *frame);
  const StateHistory history = Moving(from, to, frame->stamp - milliseconds(50));
  ASSERT_EQ(task->Step(*frame, {.states = history}), Status::kOk);
  octomap::OcTree tree(config.map.width_m);
  const auto middle = history.At(frame->stamp, config.max_extrapolation);
  ASSERT_TRUE(middle);
  ASSERT_LT((*middle - HomeAtOrigin()).norm(), 1e-6);
  test::InsertOctomap(&tree, ScanOf(*frame, *middle, config));
  EXPECT_EQ(test::Difference(task->map(), tree), "");
}

TEST(MappingTask, HoldsTheSpaceOfTheRobotAndTheOperatorsClearanceForFree) {
  const auto task = std::make_unique<MappingTask>(Config(), TracerUf7());
  const VoxelGrid& map = task->map();
  const Configuration q = HomeAtOrigin();
  EXPECT_TRUE(map.Obstacle(map.VoxelOf({0, 0, 0.1})));
  task->Start(q);

  // Of the robot as its URDF has it: nothing of its bodies is an obstacle. What is farther than the
  // clearance is one, but for the corners of the boxes about its cylinders and half a voxel.
  const hil::Plant plant(hil::TracerUf7Description(), {}, q.tail<kArmJoints>());
  const hil::RobotBodies robot = hil::RobotBodiesOf(hil::TracerUf7Description());
  const double far_m = Config().start_clearance_m + 0.1;
  int inside = 0;
  int outside = 0;
  for (int i = 0; i < map.voxel_count(); ++i) {
    const VoxelIndex v = map.VoxelAt(i);
    double distance_m = 1e9;
    for (const hil::Body& body : robot.bodies) {
      const Isometry3d X_WG = plant.X_WL(body.link) * body.X_LG;
      distance_m = std::min(distance_m, SignedDistance(body.shape, X_WG.inverse() * map.Center(v)));
    }
    if (distance_m < 0) {
      ++inside;
      ASSERT_FALSE(map.Obstacle(v)) << map.Center(v).transpose();
    } else if (distance_m > far_m) {
      ++outside;
      ASSERT_TRUE(map.Obstacle(v)) << map.Center(v).transpose();
    }
  }
  EXPECT_GT(inside, 200);
  EXPECT_GT(outside, 1000);
  // The field speaks of the same map, and no voxel is known by an operator's word alone.
  EXPECT_GT(task->field().Distance({0, 0, 0.15}), 0.1);
  EXPECT_EQ(task->field().Distance({1.5, 1, 1}), 0);
  EXPECT_EQ(map.counts().free + map.counts().occupied, 0);
}

TEST(MappingTask, DropsAndCountsAFrameWhosePoseIsNotKnown) {
  const auto task = std::make_unique<MappingTask>(Config(), TracerUf7());
  Eye eye;
  const auto frame = std::make_unique<DepthFrame>();
  eye.Shoot(HomeAtOrigin(), *frame);
  const std::uint64_t revision = task->map().revision();
  const Configuration q = HomeAtOrigin();
  const Duration beyond = Config().max_extrapolation + milliseconds(1);

  EXPECT_EQ(task->Step(*frame, {.states = StateHistory()}), Status::kStale);
  const StateHistory too_new = Moving(q, q, frame->stamp + milliseconds(1));
  EXPECT_EQ(task->Step(*frame, {.states = too_new}), Status::kStale);
  const StateHistory too_old = Moving(q, q, frame->stamp - milliseconds(100) - beyond);
  EXPECT_EQ(task->Step(*frame, {.states = too_old}), Status::kStale);
  StateHistory not_valid;
  RobotState state;
  state.q = q;
  state.stamp = frame->stamp;
  not_valid.Add(state);
  EXPECT_EQ(task->Step(*frame, {.states = not_valid}), Status::kStale);

  EXPECT_EQ(task->counters().frames, 4U);
  EXPECT_EQ(task->counters().without_pose, 4U);
  EXPECT_EQ(task->map().revision(), revision);

  const StateHistory just_in_reach =
      Moving(q, q, frame->stamp - milliseconds(100) - beyond + milliseconds(1));
  EXPECT_EQ(task->Step(*frame, {.states = just_in_reach}), Status::kOk);
  EXPECT_NE(task->map().revision(), revision);
}

TEST(MappingTask, RefusesAndCountsAFrameThatMakesNoSense) {
  const auto task = std::make_unique<MappingTask>(Config(), TracerUf7());
  Eye eye;
  const auto frame = std::make_unique<DepthFrame>();
  eye.Shoot(HomeAtOrigin(), *frame);
  frame->camera.width = -3;
  const std::uint64_t revision = task->map().revision();
  const StateHistory history = Moving(HomeAtOrigin(), HomeAtOrigin(), frame->stamp);
  EXPECT_EQ(task->Step(*frame, {.states = history}), Status::kMalformed);
  EXPECT_EQ(task->counters().refused, 1U);
  EXPECT_EQ(task->map().revision(), revision);
}

TEST(MappingTask, AddsNoFrameWhoseBaseIsInDoubt) {
  MappingConfig config = Config();
  config.localize = true;
  const auto task = std::make_unique<MappingTask>(config, TracerUf7());
  Eye eye;
  const auto frame = std::make_unique<DepthFrame>();
  const Configuration q = HomeAtOrigin();
  eye.Shoot(q, *frame);
  const StateHistory standing = Moving(q, q, frame->stamp);
  const auto see = [&](bool doubted) {
    return task->Step(*frame, {.states = standing, .base_doubted = doubted});
  };
  const std::uint64_t revision = task->map().revision();
  ASSERT_EQ(see(true), Status::kOk);
  EXPECT_EQ(task->map().revision(), revision);
  EXPECT_EQ(task->localizer().map().cells(), 0);
  EXPECT_EQ(task->scene().stamp, Time());
  EXPECT_EQ(task->counters().doubted, 1U);
  ASSERT_EQ(see(false), Status::kOk);
  EXPECT_NE(task->map().revision(), revision);
  EXPECT_GT(task->localizer().map().cells(), 0);
  EXPECT_EQ(task->scene().stamp, frame->stamp);
  EXPECT_EQ(task->counters().doubted, 1U);
}

TEST(MappingTask, TakesNothingFromTheHeapWhileItRuns) {
  const auto task = std::make_unique<MappingTask>(Config(), TracerUf7());
  Eye eye;
  const auto frame = std::make_unique<DepthFrame>();
  for (int n = 0; n < 5; ++n) {
    eye.Shoot(Posture(n), *frame);
    const StateHistory history = Moving(Posture(n), Posture(n), frame->stamp);
    const NoAllocScope no_heap;
    if (n == 0) {
      task->Start(Posture(0));
    }
    ASSERT_EQ(task->Step(*frame, {.states = history}), Status::kOk);
  }
  EXPECT_GT(task->scene().planes.size(), 0);  // the tracker was at work, too
}

TEST(MappingTask, MarksWhatThePlannerGaveUpUntilItIsSeen) {
  const auto task = std::make_unique<MappingTask>(Config(), TracerUf7());
  const auto residual = std::make_unique<ResidualVoxels>();
  const VoxelIndex deep = {30, 10, 20};
  ASSERT_TRUE(residual->voxels.push_back(deep));
  const int unknown = task->map().counts().unknown;
  task->DeclareResidual(*residual);
  EXPECT_TRUE(task->map().Residual(deep));
  EXPECT_EQ(task->map().counts().residual, 1);
  EXPECT_EQ(task->map().counts().unknown, unknown - 1);
  EXPECT_TRUE(task->map().Obstacle(deep));  // given up is not free
}

}  // namespace
}  // namespace pipewright
