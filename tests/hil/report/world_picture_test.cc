// SPDX-License-Identifier: MIT
#include "hil/report/world_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/hil/report/page.h"

namespace pipewright::hil {
namespace {

WorldView Room() {
  WorldView world;
  world.min_m = Vector3d::Zero();
  world.max_m = Vector3d(1, 1, 1);
  return world;
}

/// Faces drawn in both views together, by state.
std::map<std::string, int> FacesOf(const WorldView& world) {
  const Page page("<div>" + RenderWorld(world) + "</div>");
  std::map<std::string, int> faces;
  for (const tinyxml2::XMLElement* e : page.OfClass("face")) {
    const std::string d = e->Attribute("d");
    for (const char* state : {"got", "missed", "out"}) {
      if (Page::HasClass(*e, state)) {
        faces[state] += static_cast<int>(std::count(d.begin(), d.end(), 'M'));
      }
    }
  }
  return faces;
}

TEST(World, AVoxelShowsThreeFacesInEachView) {
  for (const int at : {0, 7, -3}) {
    WorldView world = Room();
    world.surface = {{{at, at, at}, SurfaceState::kCovered}};
    EXPECT_EQ(FacesOf(world), (std::map<std::string, int>{{"got", 6}}));
  }
}

TEST(World, FacesBetweenVoxelsAreNotDrawn) {
  WorldView world = Room();
  for (int i = 0; i < 27; ++i) {
    world.surface.push_back({{i % 3, i / 3 % 3, i / 9}, SurfaceState::kMissed});
  }
  EXPECT_EQ(FacesOf(world), (std::map<std::string, int>{{"missed", 2 * 3 * 9}}));
}

TEST(World, NearerFacesAreDrawnLater) {
  // Seen from +x, +y: the voxel at (2, 2, 2) hides the one at the origin. From the other side, not.
  WorldView world = Room();
  world.surface = {{{2, 2, 2}, SurfaceState::kCovered}, {{0, 0, 0}, SurfaceState::kMissed}};
  const Page page("<div>" + RenderWorld(world) + "</div>");
  const auto faces = page.OfClass("face");
  ASSERT_EQ(faces.size(), 12u);
  // First view, from −x, −y: depth −(i + j) + k is −2 for the covered voxel, 0 for the other.
  EXPECT_TRUE(Page::HasClass(*faces[0], "got"));
  EXPECT_TRUE(Page::HasClass(*faces[5], "missed"));
  EXPECT_TRUE(Page::HasClass(*faces[6], "missed"));
  EXPECT_TRUE(Page::HasClass(*faces[11], "got"));
}

TEST(World, ManyVoxelsBecomeCoarseAndKeepWhatWasMissed) {
  WorldView world = Room();
  for (int i = 0; i < 200; ++i) {
    for (int j = 0; j < 200; ++j) {
      const bool missed = i == 77 && j == 133;
      world.surface.push_back(
          {{i - 50, j - 50, 0}, missed ? SurfaceState::kMissed : SurfaceState::kCovered});
    }
  }
  EXPECT_LT(RenderWorld(world).size(), 500000u);
  std::map<std::string, int> faces = FacesOf(world);
  EXPECT_GE(faces["missed"], 2);
  EXPECT_LE(faces["missed"], 6);
  EXPECT_LT(faces["got"], 4 * 5000);
  EXPECT_GT(faces["got"], 2 * 1000);
}

TEST(World, AVoxelGivenTwiceTakesTheWorse) {
  WorldView world = Room();
  world.surface = {{{1, 1, 1}, SurfaceState::kCovered}, {{1, 1, 1}, SurfaceState::kMissed}};
  EXPECT_EQ(FacesOf(world), (std::map<std::string, int>{{"missed", 6}}));
}

TEST(World, TheDrawingHoldsTheWorkspaceThePathAndTheGoals) {
  WorldView world = Room();
  world.hand_path = {Vector3d(-2, 0, 0), Vector3d(0, 0, 0)};
  world.goals = {Vector3d(0, 0, 3)};
  const Page far("<div>" + RenderWorld(world) + "</div>");
  const Page near("<div>" + RenderWorld(Room()) + "</div>");
  const auto box = [](const Page& page) {
    double x = 0;
    double y = 0;
    double width = 0;
    double height = 0;
    std::sscanf(page.Named("svg").at(0)->Attribute("viewBox"), "%lf %lf %lf %lf", &x, &y, &width,
                &height);
    return std::array<double, 4>{x, y, width, height};
  };
  EXPECT_GT(box(far)[2], 1.4 * box(near)[2]);
  EXPECT_LT(box(far)[1], box(near)[1]);
  EXPECT_EQ(far.OfClass("hand").size(), 2u);
  EXPECT_EQ(far.OfClass("goals").size(), 2u);
  EXPECT_EQ(near.OfClass("hand").size(), 0u);
}

TEST(World, OutlinesWidenTheDrawingOnlyWhenTheyAreNear) {
  const auto width = [](double x_m) {
    WorldView world = Room();
    world.outlines = {{Vector3d(x_m, 0, 0), Vector3d(x_m, 1, 0)}};
    const Page page("<div>" + RenderWorld(world) + "</div>");
    double x = 0;
    double y = 0;
    double w = 0;
    std::sscanf(page.Named("svg").at(0)->Attribute("viewBox"), "%lf %lf %lf", &x, &y, &w);
    return w;
  };
  EXPECT_GT(width(1.15), width(1));
  EXPECT_EQ(width(10), width(1));
}

TEST(World, OfNothingIsEmpty) { EXPECT_EQ(RenderWorld({}), ""); }

}  // namespace
}  // namespace pipewright::hil
