// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdlib>
#include <limits>
#include <tuple>

#include "platform/core/rng.h"
#include "tests/perception/map/map_data.h"
#include "tests/perception/map/octomap_oracle.h"

namespace pipewright {
namespace {

using test::Box;
using test::Difference;
using test::InsertOctomap;
using test::InsertOurs;
using test::Scan;

// rapidcheck reads its seed from the environment; unless someone sets another, it is this one.
const bool kSeeded = setenv("RC_PARAMS", "seed=20240501 max_success=300", 0) == 0;

// A room, seen from a wandering camera; one reading in five ends before the wall.
Scan LookAround(Rng* rng, double half_room_m, double max_range_m, int points) {
  Scan scan;
  scan.max_range_m = max_range_m;
  for (int i = 0; i < 3; ++i) {
    scan.origin_W[i] = static_cast<float>(rng->Uniform(-0.3, 0.3) * half_room_m);
  }
  for (int n = 0; n < points; ++n) {
    const Vector3d d = Vector3d(rng->Normal(), rng->Normal(), rng->Normal()).normalized();
    double reach = 1e9;
    for (int i = 0; i < 3; ++i) {
      const double wall = d[i] > 0 ? half_room_m : -half_room_m;
      reach = std::min(reach, (wall - static_cast<double>(scan.origin_W[i])) / d[i]);
    }
    if (rng->Uniform() < 0.2) {
      reach *= rng->Uniform();
    }
    scan.points_W.emplace_back(scan.origin_W + (d * reach).cast<float>());
  }
  return scan;
}

struct RoomCase {
  const char* name;
  double half_room_m;
  double max_range_m;
  bool discretize;
};

constexpr RoomCase kRooms[] = {
    {"room inside the box", 0.9, -1, false},
    {"room inside the box, range limit", 0.9, 0.5, false},
    {"room beyond the box", 3.0, -1, false},
    {"room beyond the box, range limit", 3.0, 1.3, false},
    {"discretised, room inside the box", 0.9, -1, true},
    {"discretised, room beyond the box, range limit", 3.0, 1.3, true},
};

TEST(InsertScan, GivesOctomapsMapVoxelByVoxel) {
  for (const RoomCase& c : kRooms) {
    SCOPED_TRACE(c.name);
    Rng rng(11);
    VoxelGrid grid(Box(21));
    octomap::OcTree tree(0.05);
    for (int i = 0; i < 6; ++i) {
      const Scan scan = LookAround(&rng, c.half_room_m, c.max_range_m, 1500);
      InsertOurs(&grid, scan, c.discretize);
      InsertOctomap(&tree, scan, c.discretize);
      ASSERT_EQ(Difference(grid, tree), "") << "scan " << i;
    }
    EXPECT_GT(grid.counts().free, 5000);
  }
}

// Coordinates that invite trouble: on voxel borders, at centres, a float away from either.
rc::Gen<float> Awkward(int reach) {
  return rc::gen::oneOf(
      rc::gen::map(rc::gen::inRange(-reach, reach),
                   [](int i) { return static_cast<float>(i * 0.05); }),
      rc::gen::map(rc::gen::inRange(-reach, reach),
                   [](int i) { return std::nextafter(static_cast<float>(i * 0.05), 9.0F); }),
      rc::gen::map(rc::gen::inRange(-reach, reach),
                   [](int i) { return std::nextafter(static_cast<float>(i * 0.05), -9.0F); }),
      rc::gen::map(rc::gen::inRange(-reach, reach),
                   [](int i) { return static_cast<float>(i * 0.05 + 0.025); }),
      rc::gen::map(rc::gen::inRange(-50000 * reach, 50000 * reach),
                   [](int i) { return static_cast<float>(i * 1e-6); }));
}

rc::Gen<Vector3f> AwkwardPoint(int reach) {
  return rc::gen::map(rc::gen::tuple(Awkward(reach), Awkward(reach), Awkward(reach)),
                      [](const std::tuple<float, float, float>& t) {
                        return Vector3f(std::get<0>(t), std::get<1>(t), std::get<2>(t));
                      });
}

Scan AwkwardScan(int origin_reach, int point_reach) {
  Scan scan;
  scan.origin_W = *AwkwardPoint(origin_reach);
  scan.points_W = *rc::gen::container<std::vector<Vector3f>>(AwkwardPoint(point_reach));
  scan.points_W.push_back(scan.origin_W);
  // At the limit to the bit for one point, and on either side of it for the others.
  scan.max_range_m = *rc::gen::element(
      -1.0, 0.35, 0.6, static_cast<double>((scan.points_W.front() - scan.origin_W).norm()));
  return scan;
}

bool HoldsOnAwkwardScans(int origin_reach, int point_reach, bool discretize) {
  EXPECT_TRUE(kSeeded);
  return rc::check("equal to OctoMap's map", [=] {
    VoxelGrid grid(Box(8));
    octomap::OcTree tree(0.05);
    for (int i = 0; i < 3; ++i) {
      const Scan scan = AwkwardScan(origin_reach, point_reach);
      InsertOurs(&grid, scan, discretize);
      InsertOctomap(&tree, scan, discretize);
    }
    RC_ASSERT(Difference(grid, tree) == "");
  });
}

TEST(InsertScan, EqualsOctomapOnBordersWithinTheBox) {
  EXPECT_TRUE(HoldsOnAwkwardScans(7, 9, false));
}

TEST(InsertScan, EqualsOctomapForRaysThatLeaveTheBox) {
  EXPECT_TRUE(HoldsOnAwkwardScans(8, 25, false));
}

TEST(InsertScan, EqualsOctomapForRaysThatEnterTheBox) {
  EXPECT_TRUE(HoldsOnAwkwardScans(25, 25, false));
}

TEST(InsertScan, EqualsOctomapDiscretised) { EXPECT_TRUE(HoldsOnAwkwardScans(12, 20, true)); }

TEST(InsertScan, EqualsTheSharedReference) {
  const std::string folder = test::SharedMapFolder();
  if (folder.empty()) {
    GTEST_SKIP() << "SKIPPED: PIPEWRIGHT_SHARED is not set, the shared clouds were NOT checked";
  }
  const std::vector<Scan> scans = test::ReadClouds(folder + "cube_clouds.bin");
  ASSERT_EQ(scans.size(), 20U);
  VoxelGrid grid(test::WorkloadBox("cube"));
  for (const Scan& scan : scans) {
    InsertOurs(&grid, scan);
  }
  std::ifstream in(folder + "cube_map20_ref.bin", std::ios::binary);
  ASSERT_EQ(test::Get<std::uint32_t>(in), 0x314D504DU);  // "MPM1"
  const auto n = test::Get<std::uint32_t>(in);
  int known_in_box = 0;
  int differ = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    VoxelIndex v;
    for (int* axis : {&v.x, &v.y, &v.z}) {
      *axis = test::Get<std::uint16_t>(in) - 32768;
    }
    const auto log_odds = test::Get<float>(in);
    if (grid.InBox(v)) {
      ++known_in_box;
      differ += grid.State(v) == VoxelState::kUnknown || grid.LogOdds(v) != log_odds;
    }
  }
  EXPECT_EQ(differ, 0);
  EXPECT_EQ(grid.counts().free + grid.counts().occupied, known_in_box);
}

TEST(InsertScan, SharedCloudsGiveOctomapsMapInBothModes) {
  const std::string folder = test::SharedMapFolder();
  if (folder.empty()) {
    GTEST_SKIP() << "SKIPPED: PIPEWRIGHT_SHARED is not set, the shared clouds were NOT checked";
  }
  for (const char* scene : {"cube", "office"}) {
    for (const bool discretize : {false, true}) {
      SCOPED_TRACE(testing::Message() << scene << ", discretised " << discretize);
      std::vector<Scan> scans = test::ReadClouds(folder + scene + "_clouds.bin");
      ASSERT_EQ(scans.size(), 20U);
      scans.resize(scene[0] == 'c' ? 20 : 4);
      VoxelGrid grid(test::WorkloadBox(scene));
      octomap::OcTree tree(0.05);
      for (const Scan& scan : scans) {
        InsertOurs(&grid, scan, discretize);
        InsertOctomap(&tree, scan, discretize);
      }
      EXPECT_EQ(Difference(grid, tree), "");
    }
  }
}

TEST(InsertScan, CountsWhatItCannotUse) {
  VoxelGrid grid(Box(8));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const Scan scan{.origin_W = Vector3f::Zero(),
                  .max_range_m = -1,
                  .points_W = {{nan, 0, 0}, {0, inf, 0}, {0, 0, 3000}, {0.2F, 0.2F, 0.2F}}};
  for (const bool discretize : {false, true}) {
    const ScanStats stats = InsertOurs(&grid, scan, discretize);
    EXPECT_EQ(stats.points, 4);
    EXPECT_EQ(stats.rejected, 3);
    EXPECT_EQ(stats.hits, 1);
    EXPECT_GT(stats.misses, 0);
  }
  const Scan lost{.origin_W = {nan, 0, 0}, .max_range_m = -1, .points_W = {{0.1F, 0, 0}}};
  EXPECT_EQ(InsertOurs(&grid, lost).rejected, 1);
}

TEST(InsertScan, AFullPoolRefusesCountsAndKeepsWhatItHolds) {
  MapConfig config = Box(16);
  config.brick_capacity = 1;
  VoxelGrid grid(config);
  const Scan here{
      .origin_W = {0.11F, 0.11F, 0.11F}, .max_range_m = -1, .points_W = {{0.3F, 0.11F, 0.11F}}};
  EXPECT_EQ(InsertOurs(&grid, here).refused, 0);
  const Scan across{
      .origin_W = {0.11F, 0.11F, 0.11F}, .max_range_m = -1, .points_W = {{0.7F, 0.11F, 0.11F}}};
  const ScanStats stats = InsertOurs(&grid, across);
  EXPECT_EQ(stats.refused, 6);  // x = 8 .. 13: the neighbouring brick, end point included
  EXPECT_EQ(stats.hits, 0);
  EXPECT_EQ(grid.updates_refused(), 6);
  EXPECT_EQ(grid.bricks_used(), 1);
  EXPECT_EQ(grid.State({5, 2, 2}), VoxelState::kFree);
  EXPECT_EQ(grid.State({13, 2, 2}), VoxelState::kUnknown);
}

}  // namespace
}  // namespace pipewright
