// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "perception/map/ray_walk.h"
#include "platform/core/rng.h"
#include "tests/perception/map/map_data.h"
#include "tests/perception/map/octomap_oracle.h"

namespace pipewright {
namespace {

using test::Box;
using test::KeyOf;
using test::ToOctomap;

// On voxel borders, at centres, or anywhere: rays between such points meet edges and corners.
Vector3f Awkward(Rng* rng, int reach) {
  Vector3f p;
  for (int i = 0; i < 3; ++i) {
    const int cell = rng->Index(2 * reach) - reach;
    const double within[] = {0.0, 0.025, rng->Uniform(0, 0.05)};
    p[i] = static_cast<float>(cell * 0.05 + within[rng->Index(3)]);
    if (rng->Index(4) == 0) {
      p[i] = std::nextafter(p[i], rng->Index(2) == 0 ? -9.0F : 9.0F);
    }
  }
  return p;
}

TEST(RayWalk, GivesOctomapsKeys) {
  const VoxelGrid grid(Box(10));
  const octomap::OcTree tree(0.05);
  Rng rng(21);
  octomap::KeyRay keys;
  for (int n = 0; n < 20000; ++n) {
    const Vector3f from = Awkward(&rng, 18);
    const Vector3f to = Awkward(&rng, 30);
    ASSERT_TRUE(tree.computeRayKeys(ToOctomap(from), ToOctomap(to), keys));
    RayWalk ray(grid, from, to);
    for (const octomap::OcTreeKey& key : keys) {
      ASSERT_TRUE(ray.Next()) << "ray " << n;
      ASSERT_EQ(KeyOf(ray.voxel()), key) << "ray " << n;
      ASSERT_EQ(ray.inside(), grid.InBox(ray.voxel()));
      ASSERT_EQ(ray.index(), ray.inside() ? grid.IndexOf(ray.voxel()) : -1);
    }
    ASSERT_FALSE(ray.Next()) << "ray " << n;
    ASSERT_FALSE(ray.Next()) << "an ended ray stays ended";
  }
}

TEST(RayWalk, HasNothingToSayOfWhatIsNotANumberOrTooFar) {
  const VoxelGrid grid(Box(10));
  const float nan = std::nanf("");
  EXPECT_FALSE(RayWalk(grid, {0, 0, 0}, {nan, 0, 0}).Next());
  EXPECT_FALSE(RayWalk(grid, {0, nan, 0}, {1, 0, 0}).Next());
  EXPECT_FALSE(RayWalk(grid, {0, 0, 0}, {0, 0, 1e9F}).Next());
  EXPECT_FALSE(RayWalk(grid, {0.01F, 0, 0}, {0.02F, 0, 0}).Next()) << "one voxel";
}

struct Maps {
  VoxelGrid grid{Box(20)};
  octomap::OcTree tree{0.05};
};

// A few scans inside the box, so that every known voxel of either map is in both.
Maps SomeMaps(Rng* rng) {
  Maps maps;
  for (int s = 0; s < 3; ++s) {
    test::Scan scan;
    scan.origin_W = Awkward(rng, 6);
    for (int i = 0; i < 400; ++i) {
      scan.points_W.push_back(Awkward(rng, 19));
    }
    test::InsertOurs(&maps.grid, scan);
    test::InsertOctomap(&maps.tree, scan);
  }
  return maps;
}

TEST(CastRay, EndsWhereOctomapsDoes) {
  Rng rng(22);
  for (int m = 0; m < 5; ++m) {
    const Maps maps = SomeMaps(&rng);
    int hits = 0;
    for (int n = 0; n < 2000; ++n) {
      const Vector3f from = Awkward(&rng, 12);
      Vector3f along = Awkward(&rng, 10);
      along[rng.Index(3)] *= static_cast<float>(rng.Index(2));  // often along a plane or an axis
      const double max_range_m[] = {0.3, 0.55, 1.0, 2.0};
      const double range_m = max_range_m[rng.Index(4)];
      for (const bool ignore_unknown : {false, true}) {
        octomap::point3d end;
        if (along.norm() == 0) {
          continue;  // OctoMap's answer is an error message
        }
        const bool theirs =
            maps.tree.castRay(ToOctomap(from), ToOctomap(along), end, ignore_unknown, range_m);
        const RayHit ours =
            maps.grid.CastRay(from.cast<double>(), along.cast<double>(), range_m, ignore_unknown);
        ASSERT_EQ(ours.hit, theirs) << "ray " << n;
        ASSERT_EQ(KeyOf(ours.end), maps.tree.coordToKey(end)) << "ray " << n;
        hits += ours.hit ? 1 : 0;
      }
    }
    EXPECT_GT(hits, 500);
  }
}

TEST(CastRay, WithoutRangeLimitGoesToTheEndOfTheKeys) {
  Rng rng(23);
  const Maps maps = SomeMaps(&rng);
  for (int n = 0; n < 30; ++n) {
    const Vector3f from = Awkward(&rng, 25);
    const Vector3f along = Awkward(&rng, 10) + Vector3f(0.001F, 0.002F, 0.003F);
    octomap::point3d end;
    const bool theirs = maps.tree.castRay(ToOctomap(from), ToOctomap(along), end, true, -1);
    const RayHit ours = maps.grid.CastRay(from.cast<double>(), along.cast<double>(), -1, true);
    ASSERT_EQ(ours.hit, theirs) << "ray " << n;
    ASSERT_EQ(KeyOf(ours.end), maps.tree.coordToKey(end)) << "ray " << n;
  }
}

TEST(CastRay, ABatchEqualsItsRaysOneByOne) {
  Rng rng(24);
  const Maps maps = SomeMaps(&rng);
  for (int n = 0; n < 200; ++n) {
    const Vector3f from = Awkward(&rng, n % 2 == 0 ? 12 : 25);
    const double range_m = n % 3 == 0 ? 0.55 : 1.6;
    std::vector<Vector3f> along(static_cast<std::size_t>(rng.Index(23)));
    for (Vector3f& d : along) {
      d = Awkward(&rng, 4);
    }
    std::vector<RayHit> hits(along.size());
    const bool ignore_unknown = n % 4 < 2;
    maps.grid.CastRays(from, along.data(), static_cast<int>(along.size()), range_m, ignore_unknown,
                       hits.data());
    for (std::size_t i = 0; i < along.size(); ++i) {
      const RayHit one =
          maps.grid.CastRay(from.cast<double>(), along[i].cast<double>(), range_m, ignore_unknown);
      ASSERT_EQ(hits[i].hit, one.hit) << "batch " << n << ", ray " << i;
      ASSERT_EQ(hits[i].end, one.end) << "batch " << n << ", ray " << i;
    }
  }
}

TEST(CastRay, RefusesADirectionThatIsNone) {
  const VoxelGrid grid(Box(4));
  EXPECT_FALSE(grid.CastRay({0, 0, 0}, {0, 0, 0}, 1, true).hit);
  EXPECT_FALSE(grid.CastRay({0, 0, 0}, {std::nan(""), 0, 1}, 1, true).hit);
  EXPECT_FALSE(grid.CastRay({std::nan(""), 0, 0}, {0, 0, 1}, 1, true).hit);
}

// The planner's workload: unknown voxels passed and surfaces met, by 200 + 200 rays a view.
TEST(RayWalk, GivesTheSharedViewsTheirReferenceCounts) {
  const std::string folder = test::SharedMapFolder();
  if (folder.empty()) {
    GTEST_SKIP() << "SKIPPED: PIPEWRIGHT_SHARED is not set, the shared views were NOT checked";
  }
  for (const std::string scene : {"cube", "office"}) {
    VoxelGrid grid(test::WorkloadBox(scene));
    for (const test::Scan& scan : test::ReadClouds(folder + scene + "_clouds.bin")) {
      test::InsertOurs(&grid, scan);
    }
    const std::vector<test::View> views = test::ReadViews(folder + scene + "_views.bin");
    std::ifstream ref(folder + scene + "_views_ref.bin", std::ios::binary);
    ASSERT_EQ(test::Get<std::uint32_t>(ref), 0x3147504DU);  // "MPG1"
    ASSERT_EQ(test::Get<std::uint32_t>(ref), views.size());
    for (std::size_t n = 0; n < views.size(); ++n) {
      for (const bool visual : {true, false}) {
        std::uint32_t counted = 0;
        std::uint32_t hits = 0;
        for (const Vector3f& d : visual ? views[n].visual_W : views[n].coverage_W) {
          RayWalk ray(grid, views[n].p_W, views[n].p_W + d * (visual ? 3.0F : 0.4F));
          while (ray.Next() && ray.inside()) {
            if (grid.OccupiedAt(ray.index())) {
              ++hits;
              counted += visual ? 0 : test::UncoveredInWorkload(ray.voxel());
              break;
            }
            counted += visual && !grid.KnownAt(ray.index()) ? 1 : 0;
          }
        }
        ASSERT_EQ(counted, test::Get<std::uint32_t>(ref)) << scene << " view " << n;
        ASSERT_EQ(hits, test::Get<std::uint32_t>(ref)) << scene << " view " << n;
      }
    }
  }
}

}  // namespace
}  // namespace pipewright
