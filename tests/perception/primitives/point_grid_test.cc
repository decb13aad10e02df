// SPDX-License-Identifier: MIT
#include "perception/primitives/point_grid.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <vector>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

TEST(PointGrid, VisitsExactlyThePointsWithinItsWidthEachOnce) {
  Rng rng(4);
  const auto grid = std::make_unique<PointGrid>();
  for (const int count : {0, 1, 50, 2000}) {
    std::vector<Eigen::Vector3f> points;
    for (int k = 0; k < count; ++k) {
      const auto coordinate = [&] { return static_cast<float>(rng.Uniform(-3, 3)); };
      points.emplace_back(coordinate(), coordinate(), coordinate());
    }
    constexpr float kWidth_m = 0.4F;
    grid->Set(points, kWidth_m);
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector3f p(static_cast<float>(rng.Uniform(-3.5, 3.5)),
                              static_cast<float>(rng.Uniform(-3.5, 3.5)), 0);
      std::multiset<int> visited;
      grid->ForEachNear(p, [&](int i) { visited.insert(i); });
      std::multiset<int> expected;
      for (int i = 0; i < count; ++i) {
        if ((points[i] - p).squaredNorm() <= kWidth_m * kWidth_m) {
          expected.insert(i);
        }
      }
      EXPECT_EQ(visited, expected);
    }
  }
}

}  // namespace
}  // namespace pipewright
