// SPDX-License-Identifier: MIT
#include "perception/primitives/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "seen_world.h"

namespace pipewright {
namespace {

using test::Cell;
using test::Lens;
using test::LookingAt;
using test::See;
using test::World;

World PipeCell() {
  World world = Cell();
  world.pipes = {{{1.2, 1.15, 0}, {1.2, 1.15, 1.5}, 0.05},
                 {{1.2, 0, 0.9}, {1.2, 1.15, 0.9}, 0.04},
                 {{0, 0.2, 0.55}, {1.5, 0.2, 0.55}, 0.05}};
  return world;
}

/// A camera that sways through a cell.
struct Ride {
  PrimitiveConfig config;
  Lens lens;
  Rng rng{21};
  int frame = 0;
  std::unique_ptr<Cloud> cloud = std::make_unique<Cloud>();
  std::unique_ptr<PrimitiveTracker> tracker = std::make_unique<PrimitiveTracker>(config, 7);

  explicit Ride(const PrimitiveConfig& c = {}) : config(c) {
    tracker = std::make_unique<PrimitiveTracker>(config, 7);
  }

  /// X_VW moves what the tracker is told of the camera's pose into another frame V.
  void Frame(const World& world, const Isometry3d& X_VW = Isometry3d::Identity()) {
    const double a = 0.03 * frame;
    const Vector3d eye{0.5 + 0.15 * std::cos(1.7 * a), 0.75 + 0.3 * std::sin(a),
                       0.8 + 0.2 * std::sin(0.7 * a)};
    const Vector3d target{1.2, 0.75 + 0.6 * std::sin(1.3 * a), 0.6 + 0.3 * std::cos(0.9 * a)};
    Step(world, LookingAt(eye, target), X_VW);
  }
  void Step(const World& world, const Isometry3d& X_WS,
            const Isometry3d& X_VW = Isometry3d::Identity()) {
    See(world, X_WS, lens, config.noise, rng, *cloud);
    cloud->X_WS = X_VW * X_WS;
    cloud->stamp = Time{} + std::chrono::milliseconds(66 * frame++);
    tracker->Step(*cloud);
  }
};

void ExpectWellFormed(const Scene& scene) {
  for (const PlaneEstimate& plane : scene.planes) {
    EXPECT_TRUE(plane.covariance.allFinite() && plane.n_W.allFinite());
    EXPECT_NEAR(plane.n_W.norm(), 1, 1e-12);
    EXPECT_NEAR(plane.n_W.dot(plane.p_WCentroid), plane.d_m, 1e-9);
    EXPECT_NEAR((plane.e1_W.cross(plane.e2_W) - plane.n_W).norm(), 0, 1e-12);
    EXPECT_GT(plane.covariance(3, 3), 0);
  }
  for (const PipeEstimate& pipe : scene.pipes) {
    EXPECT_TRUE(pipe.covariance.allFinite() && pipe.l_W.allFinite());
    EXPECT_NEAR(pipe.l_W.norm(), 1, 1e-12);
    EXPECT_LT(pipe.extent_lo_m, pipe.extent_hi_m);
  }
}

TEST(Tracker, KnowsTheCellAndItsThreePipesFromAMovingCamera) {
  Ride ride;
  const World world = PipeCell();
  for (int k = 0; k < 300; ++k) {
    ride.Frame(world);
    ExpectWellFormed(ride.tracker->scene());
  }
  const Scene& scene = ride.tracker->scene();
  ASSERT_EQ(scene.pipes.size(), 3);
  EXPECT_EQ(scene.planes.size(), 4);
  for (const test::TruePipe& truth : world.pipes) {
    const Vector3d l = (truth.to_W - truth.from_W).normalized();
    int hits = 0;
    for (const PipeEstimate& pipe : scene.pipes) {
      const Vector3d w = pipe.p_W - truth.from_W;
      const double off = (w - l.dot(w) * l).norm();
      hits += off < 0.004 && std::abs(l.dot(pipe.l_W)) > 0.9999 &&
              std::abs(pipe.radius_m - truth.radius_m) < 0.002;
    }
    EXPECT_EQ(hits, 1);
  }
  for (const PlaneEstimate& plane : scene.planes) {
    double least = 1e9;
    for (const test::TruePlane& truth : world.planes) {
      least = std::min(least, (plane.n_W - truth.n_W).norm() + std::abs(plane.d_m - truth.d_m));
    }
    EXPECT_LT(least, 0.005);
  }
}

TEST(Tracker, GivesNoPipeInAnEmptyCellAndOneTrackAWall) {
  Ride ride;
  for (int k = 0; k < 600; ++k) {
    ride.Frame(Cell());
    ASSERT_EQ(ride.tracker->scene().pipes.size(), 0) << k;
  }
  EXPECT_EQ(ride.tracker->scene().planes.size(), 4);
}

TEST(Tracker, ShowsAPrimitiveOnlyWhenSeenOftenEnough) {
  Ride ride;
  const World world = PipeCell();
  for (int k = 0; k < ride.config.confirm_frames; ++k) {
    EXPECT_EQ(ride.tracker->scene().planes.size(), 0);
    ride.Frame(world);
  }
  EXPECT_GT(ride.tracker->scene().planes.size(), 0);
}

TEST(Tracker, DoubtsAndThenDropsAPipeThatIsSeenThroughButNotOneThatIsOutOfView) {
  Ride ride;
  World world = Cell();
  world.pipes = {{{1.2, 1.0, 0}, {1.2, 1.0, 1.5}, 0.06}};
  const Isometry3d X_WS = LookingAt({0.5, 0.75, 0.8}, {1.2, 0.9, 0.7});
  for (int k = 0; k < 10; ++k) {
    ride.Step(world, X_WS);
  }
  ASSERT_EQ(ride.tracker->scene().pipes.size(), 1);
  const double before = ride.tracker->scene().pipes[0].covariance.trace();
  const Isometry3d away = LookingAt({0.5, 0.75, 0.8}, {0.5, 0.0, 0.7});
  for (int k = 0; k < 50; ++k) {
    ride.Step(world, away);
  }
  ASSERT_EQ(ride.tracker->scene().pipes.size(), 1);
  const double unseen = ride.tracker->scene().pipes[0].covariance.trace();
  EXPECT_GT(unseen, before);
  world.pipes.clear();
  for (int k = 0; k < 4; ++k) {
    ride.Step(world, X_WS);
  }
  ASSERT_EQ(ride.tracker->scene().pipes.size(), 1);
  EXPECT_GT(ride.tracker->scene().pipes[0].covariance.trace(), 2 * unseen);
  for (int k = 0; k < ride.config.contradictions_max; ++k) {
    ride.Step(world, X_WS);
  }
  EXPECT_EQ(ride.tracker->scene().pipes.size(), 0);
}

TEST(Tracker, DoesNotDependOnWhereTheFramesOriginIs) {
  Isometry3d X_VW = Isometry3d::Identity();
  X_VW.translation() = Vector3d(5, -3, 2);
  Ride at_home;
  Ride elsewhere;
  for (int k = 0; k < 60; ++k) {
    at_home.Frame(PipeCell());
    elsewhere.Frame(PipeCell(), X_VW);
  }
  const Scene& a = at_home.tracker->scene();
  const Scene& b = elsewhere.tracker->scene();
  ASSERT_EQ(a.planes.size(), b.planes.size());
  ASSERT_EQ(a.pipes.size(), b.pipes.size());
  Mat<4, 4> T = Mat<4, 4>::Identity();
  T.topLeftCorner<3, 3>() = X_VW.linear();
  T.block<1, 3>(3, 0) = X_VW.translation().transpose() * X_VW.linear();
  for (int k = 0; k < a.planes.size(); ++k) {
    const Mat<4, 4> moved = T * a.planes[k].covariance * T.transpose();
    EXPECT_LT((moved - b.planes[k].covariance).norm(), 0.02 * moved.norm());
    EXPECT_LT((X_VW.linear() * a.planes[k].n_W - b.planes[k].n_W).norm(), 1e-3);
  }
  Mat<7, 7> P = Mat<7, 7>::Identity();
  P.topLeftCorner<3, 3>() = P.block<3, 3>(3, 3) = X_VW.linear();
  for (int k = 0; k < a.pipes.size(); ++k) {
    const Mat<7, 7> moved = P * a.pipes[k].covariance * P.transpose();
    EXPECT_LT((moved - b.pipes[k].covariance).norm(), 0.02 * moved.norm());
  }
}

TEST(Tracker, MergesTwoPartsOfAWallOnceItIsSeenBetweenThem) {
  Ride ride;
  ride.lens.fov_rad = 0.7;
  World world;
  world.planes = {{-Vector3d::UnitX(), -1.5}};
  const auto look = [&](double y_m, int frames) {
    for (int k = 0; k < frames; ++k) {
      ride.Step(world, LookingAt({0.3, y_m, 0.8}, {1.5, y_m, 0.8}));
    }
  };
  look(-1.0, 10);
  look(1.0, 10);
  ASSERT_EQ(ride.tracker->scene().planes.size(), 2);
  const double alone = ride.tracker->scene().planes[0].covariance(3, 3);
  look(0.0, 10);
  ASSERT_EQ(ride.tracker->scene().planes.size(), 1);
  EXPECT_EQ(ride.tracker->counters().merged, 1U);
  const PlaneEstimate& plane = ride.tracker->scene().planes[0];
  EXPECT_GT(plane.extent_hi_m[0] - plane.extent_lo_m[0], 2.5);
  EXPECT_EQ(plane.frames_seen, 30);
  EXPECT_NEAR(plane.d_m, -1.5, 0.005);
  EXPECT_LT(plane.covariance(3, 3), alone);
}

TEST(Tracker, CountsFramesThatMakeNoSenseAndKeepsWhatItKnows) {
  Ride ride;
  for (int k = 0; k < 10; ++k) {
    ride.Frame(PipeCell());
  }
  const int planes = ride.tracker->scene().planes.size();
  ride.cloud->width = 0;
  ride.tracker->Step(*ride.cloud);
  EXPECT_EQ(ride.tracker->counters().refused, 1U);
  EXPECT_EQ(ride.tracker->scene().planes.size(), planes);
}

TEST(Tracker, GivesTheSameSceneForTheSameFrames) {
  Ride one;
  Ride two;
  for (int k = 0; k < 40; ++k) {
    one.Frame(PipeCell());
    two.Frame(PipeCell());
  }
  const Scene& a = one.tracker->scene();
  const Scene& b = two.tracker->scene();
  ASSERT_EQ(a.planes.size(), b.planes.size());
  for (int k = 0; k < a.planes.size(); ++k) {
    EXPECT_EQ(a.planes[k].d_m, b.planes[k].d_m);
    EXPECT_EQ(a.planes[k].covariance, b.planes[k].covariance);
  }
}

}  // namespace
}  // namespace pipewright
