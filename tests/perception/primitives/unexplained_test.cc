// SPDX-License-Identifier: MIT
#include "perception/primitives/unexplained.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

/// z = 2, seen from the origin between -1 and 1 in x and -0.5 and 0.5 in y.
DetectedPlane Wall() {
  DetectedPlane plane;
  plane.fit.n_S = -Vector3d::UnitZ();
  plane.fit.d_m = -2;
  plane.p_SCentroid = {0, 0, 2};
  plane.lo_m[0] = -1;
  plane.hi_m[0] = 1;
  plane.lo_m[1] = -0.5;
  plane.hi_m[1] = 0.5;
  return plane;
}

/// Upright, of radius 0.1, half a metre each way.
DetectedPipe Riser() {
  DetectedPipe pipe;
  pipe.fit.p_S = {0, 0, 1.5};
  pipe.fit.l_S = Vector3d::UnitY();
  pipe.fit.radius_m = 0.1;
  pipe.lo_m = -0.5;
  pipe.hi_m = 0.5;
  return pipe;
}

constexpr PointNoise kEven{.depth = {}, .sigma_m = 0.01};
constexpr PointNoise kOfDepth{.depth = DepthNoise{.c_1pm = 0.004, .step_m = 0}};
constexpr ExplainConfig kConfig{.sigmas = 4, .border_m = 0.1};

TEST(Explains, TellsAPlanesPointsByDistanceAndBorder) {
  const struct {
    const char* name;
    Vector3d p_S;
    bool expected;
  } cases[] = {{"on it", {0.3, 0.2, 2}, true},
               {"behind, within the gate", {0.3, 0.2, 2.039}, true},
               {"behind", {0.3, 0.2, 2.041}, false},
               {"before", {0.3, 0.2, 1.959}, false},
               {"at the border", {1.09, -0.59, 2}, true},
               {"beyond one side", {1.11, 0, 2}, false},
               {"beyond the other", {0, -0.61, 2}, false}};
  for (const auto& c : cases) {
    EXPECT_EQ(Explains(Wall(), c.p_S, kEven, kConfig), c.expected) << c.name;
  }
}

TEST(Explains, TellsAPipesPointsByDistanceAndEnds) {
  const struct {
    const char* name;
    Vector3d p_S;
    bool expected;
  } cases[] = {{"on it", {0, 0.2, 1.4}, true},
               {"on its side", {-0.1, 0.2, 1.5}, true},
               {"outside, within the gate", {0.139, 0, 1.5}, true},
               {"outside", {0.141, 0, 1.5}, false},
               {"inside", {0.059, 0, 1.5}, false},
               {"on the axis", {0, 0, 1.5}, false},
               {"at its end", {0, 0.59, 1.4}, true},
               {"beyond its end", {0, -0.61, 1.4}, false}};
  for (const auto& c : cases) {
    EXPECT_EQ(Explains(Riser(), c.p_S, kEven, kConfig), c.expected) << c.name;
  }
}

TEST(Explains, GrantsAnImagesPointsTheNoiseOfTheirDepth) {
  // 4 sigma at z = 2: 4 * 0.004 * 4 = 0.064.
  EXPECT_TRUE(Explains(Wall(), {0, 0, 2.06}, kOfDepth, kConfig));
  EXPECT_FALSE(Explains(Wall(), {0, 0, 2.07}, kOfDepth, kConfig));
  // At z = 1.4 before the pipe: 0.031; on its side the rays graze, at a fifth of that.
  EXPECT_TRUE(Explains(Riser(), {0, 0, 1.372}, kOfDepth, kConfig));
  EXPECT_FALSE(Explains(Riser(), {0, 0, 1.367}, kOfDepth, kConfig));
  EXPECT_FALSE(Explains(Riser(), {0.12, 0, 1.5}, kOfDepth, kConfig));
}

TEST(Explains, GrantsWhatDepartsFromItsShapeThatDeparture) {
  DetectedPlane wall = Wall();
  DetectedPipe riser = Riser();
  wall.fit.chi2 = riser.fit.chi2 = 4;
  EXPECT_TRUE(Explains(wall, {0, 0, 2.079}, kEven, kConfig));
  EXPECT_FALSE(Explains(wall, {0, 0, 2.081}, kEven, kConfig));
  EXPECT_TRUE(Explains(riser, {0.179, 0, 1.5}, kEven, kConfig));
  wall.fit.chi2 = 0.25;
  EXPECT_TRUE(Explains(wall, {0, 0, 2.039}, kEven, kConfig)) << "a good fit narrows nothing";
}

TEST(Unexplained, NumbersThePointsOfNothingAndPassesOverWhatIsNoReading) {
  const std::vector<Eigen::Vector3f> points{{0, 0, 2},        {0, 0, 1},  {NAN, 0, 1}, {0, 0, 1.4F},
                                            {0, INFINITY, 1}, {0, 0, -1}, {0, 0, 0},   {2, 0, 2}};
  const DetectedPlane planes[] = {Wall()};
  const DetectedPipe pipes[] = {Riser()};
  std::vector<int> numbers(points.size());
  const auto of_nothing = [&](const PointNoise& noise) {
    int count = 0;
    {
      const test::NoAllocScope no_heap;
      count = Unexplained(points, planes, pipes, noise, kConfig, numbers);
    }
    return std::vector<int>(numbers.begin(), numbers.begin() + count);
  };
  EXPECT_EQ(of_nothing(kEven), (std::vector<int>{1, 5, 6, 7}));
  EXPECT_EQ(of_nothing(kOfDepth), (std::vector<int>{1, 7}));
  EXPECT_EQ(Unexplained(points, {}, {}, kEven, kConfig, numbers), 6);
}

}  // namespace
}  // namespace pipewright
