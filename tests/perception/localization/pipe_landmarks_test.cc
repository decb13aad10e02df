// SPDX-License-Identifier: MIT
#include "perception/localization/pipe_landmarks.h"

#include <gtest/gtest.h>

namespace pipewright {
namespace {

/// Upright, of radius 5 cm, from the floor to 1 m.
PipeEstimate Riser(std::uint32_t id, double x_m, int frames_seen) {
  PipeEstimate pipe;
  pipe.id = id;
  pipe.p_W = {x_m, 0, 0.5};
  pipe.l_W = Vector3d::UnitZ();
  pipe.radius_m = 0.05;
  pipe.extent_lo_m = -0.5;
  pipe.extent_hi_m = 0.5;
  pipe.frames_seen = frames_seen;
  return pipe;
}

Scene SceneOf(const PipeEstimate& pipe) {
  Scene scene;
  EXPECT_TRUE(scene.pipes.push_back(pipe));
  return scene;
}

TEST(PipeLandmarks, GiveTheSurfaceNearestToAPointWithinReach) {
  PipeLandmarks pipes;
  pipes.Update(SceneOf(Riser(1, 2, 50)));
  ASSERT_EQ(pipes.size(), 1);
  struct Case {
    const char* name;
    Vector3d p_W;
    bool found;
    Vector3d n_W;
  };
  const Case kCases[] = {
      {"outside", {1.94, 0, 0.5}, true, -Vector3d::UnitX()},
      {"inside", {2, 0.04, 0.2}, true, Vector3d::UnitY()},
      {"too far", {1.9, 0, 0.5}, false, {}},
      {"beyond the end", {1.95, 0, 1.01}, false, {}},
      {"at the end", {1.95, 0, 0.98}, false, {}},
      {"on the axis", {2, 0, 0.5}, false, {}},
  };
  for (const Case& c : kCases) {
    Surfel surface;
    ASSERT_EQ(pipes.Find(c.p_W, surface) >= 0, c.found) << c.name;
    if (c.found) {
      EXPECT_LT((surface.n_W - c.n_W).norm(), 1e-12) << c.name;
      EXPECT_NEAR((surface.p_W - Vector3d(2, 0, surface.p_W.z())).norm(), 0.05, 1e-12) << c.name;
    }
  }
}

TEST(PipeLandmarks, StayWhereTheyWereWhenTheyBecameOne) {
  PipeLandmarks pipes;
  pipes.Update(SceneOf(Riser(1, 2, 5)));
  EXPECT_EQ(pipes.size(), 0) << "seen too seldom";
  pipes.Update(SceneOf(Riser(1, 2, 30)));
  PipeEstimate moved = Riser(1, 2.01, 31);
  moved.extent_hi_m = 1.5;  // longer than it was
  pipes.Update(SceneOf(moved));
  ASSERT_EQ(pipes.size(), 1);
  Surfel surface;
  ASSERT_EQ(pipes.Find({1.95, 0, 1.8}, surface), 0);
  EXPECT_NEAR(surface.p_W.x(), 1.95, 1e-12);
}

TEST(PipeLandmarks, ThatAreRefutedStaySoWhileTheSceneHasThem) {
  PipeLandmarks pipes;
  Scene both = SceneOf(Riser(1, 2, 50));
  ASSERT_TRUE(both.pipes.push_back(Riser(2, 3, 50)));
  pipes.Update(both);
  Surfel surface;
  const int second = pipes.Find({2.95, 0, 0.5}, surface);
  ASSERT_GE(second, 0);
  pipes.Refute(second);
  pipes.Update(both);
  EXPECT_LT(pipes.Find({2.95, 0, 0.5}, surface), 0);
  EXPECT_GE(pipes.Find({1.95, 0, 0.5}, surface), 0);
  pipes.Update(SceneOf(Riser(1, 2, 50)));
  pipes.Update(both);
  EXPECT_GE(pipes.Find({2.95, 0, 0.5}, surface), 0) << "seen anew";
}

TEST(PipeLandmarks, ForgetWhatTheSceneGivesUp) {
  PipeLandmarks pipes;
  pipes.Update(SceneOf(Riser(1, 2, 30)));
  pipes.Update(SceneOf(Riser(2, 2, 5)));
  EXPECT_EQ(pipes.size(), 0);
}

}  // namespace
}  // namespace pipewright
