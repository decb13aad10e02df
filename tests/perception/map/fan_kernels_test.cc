// SPDX-License-Identifier: MIT
// Rays side by side against the same rays one at a time, with and without AVX2. That one at a time
// is OctoMap's is tested in ray_test and scan_test.
#include "perception/map/fan_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "perception/map/ray_walk.h"
#include "platform/core/rng.h"
#include "tests/perception/map/octomap_oracle.h"
#include "tests/support/fan_isa.h"

namespace pipewright {
namespace {

using test::Box;

using RayFan = test::FanIsa;

INSTANTIATE_TEST_SUITE_P(Isa, RayFan, testing::Bool(), RayFan::Of);

// Mostly anywhere; now and then on borders, at centres, along axes and diagonals.
Vector3f Place(Rng* rng, double reach_m) {
  Vector3f p;
  const bool awkward = rng->Index(3) == 0;
  for (int i = 0; i < 3; ++i) {
    const double x = rng->Uniform(-reach_m, reach_m);
    p[i] = static_cast<float>(awkward ? std::round(x * 40) / 40 : x);
  }
  return p;
}

VoxelGrid SomeGrid(Rng* rng, int n) {
  VoxelGrid grid(Box(n));
  for (int s = 0; s < 4; ++s) {
    test::Scan scan;
    scan.origin_W = Place(rng, n * 0.04);
    for (int i = 0; i < 300; ++i) {
      scan.points_W.push_back(Place(rng, n * 0.05));
    }
    test::InsertOurs(&grid, scan);
  }
  return grid;
}

SegmentTrace Walked(const VoxelGrid& grid, const Vector3f& from, const Vector3f& to) {
  SegmentTrace trace;
  for (RayWalk ray(grid, from, to); ray.Next() && ray.inside();) {
    if (grid.OccupiedAt(ray.index())) {
      trace.hit = true;
      trace.end = ray.voxel();
      break;
    }
    trace.unknown += grid.KnownAt(ray.index()) ? 0 : 1;
  }
  return trace;
}

TEST_P(RayFan, TracesEachSegmentAsAWalkDoes) {
  Rng rng(31);
  int hits = 0;
  for (int m = 0; m < 60; ++m) {
    const int n = 1 + rng.Index(24);
    const VoxelGrid grid = SomeGrid(&rng, n);
    const Vector3f from = Place(&rng, n * (m % 4 == 0 ? 0.06 : 0.05));
    std::vector<Vector3f> to(static_cast<std::size_t>(rng.Index(600)));
    for (Vector3f& p : to) {
      p = Place(&rng, n * (m % 2 == 0 ? 0.05 : 0.15));
    }
    if (!to.empty()) {
      to.front() = from;
      to.back() = {NAN, 0, 1e9F};
    }
    std::vector<SegmentTrace> traces(to.size());
    grid.TraceSegments(from, to.data(), static_cast<int>(to.size()), traces.data());
    for (std::size_t i = 0; i < to.size(); ++i) {
      const SegmentTrace walked = Walked(grid, from, to[i]);
      ASSERT_EQ(traces[i].unknown, walked.unknown) << "map " << m << ", segment " << i;
      ASSERT_EQ(traces[i].hit, walked.hit) << "map " << m << ", segment " << i;
      ASSERT_EQ(traces[i].end, walked.end) << "map " << m << ", segment " << i;
      hits += walked.hit ? 1 : 0;
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST_P(RayFan, CastsEachRayAsAloneItWouldBe) {
  Rng rng(32);
  int hits = 0;
  for (int m = 0; m < 60; ++m) {
    const int n = 1 + rng.Index(24);
    const VoxelGrid grid = SomeGrid(&rng, n);
    const Vector3f from = Place(&rng, n * 0.05);
    std::vector<Vector3f> along(static_cast<std::size_t>(rng.Index(300)));
    for (Vector3f& d : along) {
      d = Place(&rng, 1);
    }
    const double ranges_m[] = {-1, 0, 0.06, 0.15, 0.7, 2.5};
    const double range_m = ranges_m[m % 6];
    const bool ignore_unknown = range_m > 0 && m % 2 == 0;
    std::vector<RayHit> many(along.size());
    grid.CastRays(from, along.data(), static_cast<int>(along.size()), range_m, ignore_unknown,
                  many.data());
    for (std::size_t i = 0; i < along.size(); ++i) {
      const RayHit one =
          grid.CastRay(from.cast<double>(), along[i].cast<double>(), range_m, ignore_unknown);
      ASSERT_EQ(many[i].hit, one.hit) << "map " << m << ", ray " << i;
      ASSERT_EQ(many[i].end, one.end) << "map " << m << ", ray " << i;
      hits += one.hit ? 1 : 0;
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST_P(RayFan, InsertsWhatOctomapInserts) {
  Rng rng(33);
  for (int m = 0; m < 20; ++m) {
    VoxelGrid grid(Box(12));
    octomap::OcTree tree(0.05);
    for (int s = 0; s < 3; ++s) {
      test::Scan scan;
      scan.origin_W = Place(&rng, 0.5);
      scan.max_range_m = m % 3 == 0 ? -1 : 0.1 * m;
      for (int i = 0; i < 700; ++i) {
        scan.points_W.push_back(Place(&rng, m % 2 == 0 ? 0.6 : 1.5));
      }
      const bool discretize = m % 4 == 3;
      test::InsertOurs(&grid, scan, discretize);
      test::InsertOctomap(&tree, scan, discretize);
      ASSERT_EQ(test::Difference(grid, tree), "") << "map " << m << ", scan " << s;
    }
  }
}

}  // namespace
}  // namespace pipewright
