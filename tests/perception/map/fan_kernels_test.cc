// SPDX-License-Identifier: MIT
// Rays side by side against the same rays one at a time, with and without AVX2. That one at a time
// is OctoMap's is tested in ray_test and scan_test.
#include "perception/map/fan_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "perception/map/fan_origin.h"
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

// What a scan of one ray makes of an empty map, against OctoMap.
std::string DifferenceOfOneRay(double width_m, int n, const Vector3f& from, const Vector3f& to) {
  MapConfig config = Box(n);
  config.width_m = width_m;
  config.field_range_m = 20 * width_m;
  VoxelGrid grid(config);
  octomap::OcTree tree(width_m);
  const test::Scan scan{.origin_W = from, .max_range_m = -1, .points_W = {to}};
  test::InsertOurs(&grid, scan);
  test::InsertOctomap(&tree, scan);
  return test::Difference(grid, tree);
}

// Three crossings follow so near upon one another that only the first and the last are sure to come
// in this order: the voxel after the first two may be another than the one that is passed.
TEST_P(RayFan, PassesNoOtherVoxelWhereThreeCrossingsMeet) {
  EXPECT_EQ(DifferenceOfOneRay(0.02, 26, {-0.239999995F, 0.129999995F, 0.189999998F},
                               {0.319999993F, 0.330000013F, -0.0900000036F}),
            "");
  EXPECT_EQ(DifferenceOfOneRay(1.0 / 3, 46, {-10.666666F, 11.333333F, -12.333333F},
                               {-3.16666675F, 8.33333302F, 14.666667F}),
            "");
  EXPECT_EQ(DifferenceOfOneRay(0.05, 40, {-0.0500000007F, -1.27499998F, -1.79999995F},
                               {2.04999995F, -3, 0.600000024F}),
            "");
}

// Walls on borders of voxels, seen from centres and from corners: every ray ends within rounding of
// a crossing, and many have crossings of two and three axes in one.
TEST_P(RayFan, InsertsReadingsOfWallsOnBordersAsOctomapDoes) {
  constexpr int kHalfRoom = 16;  // voxels
  constexpr double kWidth_m = 0.05;
  for (const double part : {0.0, 0.5, 0.3}) {
    VoxelGrid grid(Box(20));
    octomap::OcTree tree(kWidth_m);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        test::Scan scan;
        scan.origin_W = Vector3f::Constant(static_cast<float>((side + part) * kWidth_m));
        for (int u = -kHalfRoom; u <= kHalfRoom; ++u) {
          for (int v = -kHalfRoom; v <= kHalfRoom; ++v) {
            Vector3d p = Vector3d(u, v, u - v) * kWidth_m;
            p[axis] = side * kHalfRoom * kWidth_m;
            scan.points_W.emplace_back(p.cast<float>());
          }
        }
        test::InsertOurs(&grid, scan);
        test::InsertOctomap(&tree, scan);
        ASSERT_EQ(test::Difference(grid, tree), "")
            << "origin at " << part << ", axis " << axis << ", side " << side;
      }
    }
  }
}

// Nothing but what is no segment is left to the caller: a walk one at a time costs ten times more.
TEST_P(RayFan, LeavesToBeWalkedOnlyWhatIsNoSegment) {
  const MapConfig box = Box(20);
  std::vector<std::uint32_t> bits(40 * 40 * 40 / 32);
  fan::Origin origin;
  ASSERT_TRUE(AimFrom(box, {0.05F, 0.1F, 0.15F}, HalfWidth::kFloat, &origin));
  std::vector<Vector3f> ends_W;
  for (int i = -19; i < 19; ++i) {
    ends_W.emplace_back(static_cast<float>(i * 0.05), 0.9F, static_cast<float>(i * -0.05));
    ends_W.emplace_back(-0.8F, static_cast<float>(i * 0.1), static_cast<float>(i * 0.1));
  }
  const auto n = static_cast<int>(ends_W.size());
  ends_W.emplace_back(NAN, 0, 0);
  ends_W.emplace_back(0, 1e9F, 0);
  std::vector<int> left(ends_W.size() + 1);
  ASSERT_EQ(fan::Mark(origin, ends_W.front().data(), n + 2, bits.data(), left.data()), 2);
  EXPECT_EQ(left[0], n);
  EXPECT_EQ(left[1], n + 1);
}

}  // namespace
}  // namespace pipewright
