// SPDX-License-Identifier: MIT
#include "perception/cloud/point_grid.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <vector>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

constexpr float kWidth_m = 0.4F;

std::vector<Eigen::Vector3f> InBox(int count, Rng& rng) {
  std::vector<Eigen::Vector3f> points;
  for (int k = 0; k < count; ++k) {
    const auto coordinate = [&] { return static_cast<float>(rng.Uniform(-3, 3)); };
    points.emplace_back(coordinate(), coordinate(), coordinate());
  }
  return points;
}

Eigen::Vector3f InPlane(Rng& rng) {
  const auto x = static_cast<float>(rng.Uniform(-3.5, 3.5));
  return {x, static_cast<float>(rng.Uniform(-3.5, 3.5)), 0};
}

std::multiset<int> Near(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& p) {
  std::multiset<int> near;
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    if ((points[i] - p).squaredNorm() <= kWidth_m * kWidth_m) {
      near.insert(i);
    }
  }
  return near;
}

TEST(PointGrid, VisitsExactlyThePointsWithinItsWidthEachOnce) {
  Rng rng(4);
  const auto grid = std::make_unique<PointGrid>();
  for (const int count : {0, 1, 50, 2000}) {
    const std::vector<Eigen::Vector3f> points = InBox(count, rng);
    grid->Set(points, kWidth_m);
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector3f p = InPlane(rng);
      std::multiset<int> visited;
      grid->ForEachNear(p, [&](int i) { visited.insert(i); });
      EXPECT_EQ(visited, Near(points, p));
    }
  }
}

TEST(PointGrid, WhatIsTakenIsVisitedNoMoreAndWhatIsRefusedStays) {
  Rng rng(5);
  const auto grid = std::make_unique<PointGrid>();
  const std::vector<Eigen::Vector3f> points = InBox(2000, rng);
  grid->Set(points, kWidth_m);
  std::set<int> taken;
  for (int k = 0; k < 500; ++k) {
    const Eigen::Vector3f p = InPlane(rng);
    std::multiset<int> expected = Near(points, p);
    for (const int i : taken) {
      expected.erase(i);
    }
    std::multiset<int> visited;
    grid->ForEachNear(p, [&](int i) { visited.insert(i); });
    EXPECT_EQ(visited, expected);
    visited.clear();
    grid->TakeNear(p, [&](int i) {
      visited.insert(i);
      if (i % 3 == 0) {
        return false;
      }
      taken.insert(i);
      return true;
    });
    EXPECT_EQ(visited, expected);
  }
  EXPECT_GT(taken.size(), 100U);
}

}  // namespace
}  // namespace pipewright
