// SPDX-License-Identifier: MIT
// The evaluator's rays side by side against the walk that defines them, one at a time, with and
// without AVX2; also where a geometric definition leaves open which of two voxels comes first.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "perception/map/fan_kernels.h"
#include "tests/plan/gain/gain_fixture.h"
#include "tests/support/fan_isa.h"

namespace pipewright {
namespace {

/// The voxels of {p_W + t d, 0 <= t <= length_m}, in order, until visit(v) is false: the nearest
/// crossing next, of equal ones the later axis. Amanatides, Woo (1987).
template <typename Visit>
void Walk(const MapConfig& map, const Vector3d& p_W, const Vector3d& d, double length_m,
          Visit visit) {
  // The evaluator counts cells from one before the box.
  const Vector3d corner(map.lo.x - 1, map.lo.y - 1, map.lo.z - 1);
  const Vector3d origin = p_W / map.width_m - corner;
  int at[3];
  double next[3];
  for (int i = 0; i < 3; ++i) {
    at[i] = static_cast<int>(std::floor(origin[i]));
    next[i] = d[i] == 0 ? INFINITY : ((d[i] > 0 ? at[i] + 1 : at[i]) - origin[i]) / d[i];
  }
  while (visit(VoxelIndex{at[0] + map.lo.x - 1, at[1] + map.lo.y - 1, at[2] + map.lo.z - 1})) {
    int axis = next[0] < next[1] ? 0 : 1;
    axis = next[axis] < next[2] ? axis : 2;
    if (next[axis] > length_m / map.width_m) {
      return;
    }
    at[axis] += d[axis] > 0 ? 1 : -1;
    next[axis] += std::abs(1 / d[axis]);
  }
}

bool Stops(const VoxelGrid& map, const VoxelIndex& v) {
  return !map.InBox(v) || map.State(v) == VoxelState::kOccupied;
}

bool Blocked(const VoxelGrid& map, const Vector3d& p_W, const Vector3d& d, double length_m) {
  bool blocked = false;
  Walk(map.config(), p_W, d, length_m, [&](const VoxelIndex& v) {
    blocked = map.State(v) == VoxelState::kOccupied;
    return !Stops(map, v);
  });
  return blocked;
}

/// How many voxels that are `wanted` the rays pass: all, and distinct ones.
struct Passed {
  int all = 0;
  std::set<int> distinct;
};

template <typename Wanted>
Passed Pass(const VoxelGrid& map, const Isometry3d& X_WS, const RaySet& rays, double length_m,
            double blocked_m, Wanted wanted) {
  Passed passed;
  const Vector3d& p_W = X_WS.translation();
  for (const Vector3d& d_S : rays.directions) {
    const Vector3d d = X_WS.linear() * d_S;
    if (blocked_m > 0 && Blocked(map, p_W, d, blocked_m)) {
      continue;
    }
    Walk(map.config(), p_W, d, length_m, [&](const VoxelIndex& v) {
      if (map.InBox(v) && wanted(map, v)) {
        ++passed.all;
        passed.distinct.insert(map.IndexOf(v));
      }
      return !Stops(map, v);
    });
  }
  return passed;
}

bool Room(const VoxelGrid& map, const VoxelIndex& v) {
  return !map.InWorkspace(v) && map.State(v) == VoxelState::kUnknown && !map.Swept(v);
}

/// Anywhere; on voxels' borders and centres; in every other case along axes and diagonals too.
Viewpoint Place(const MapConfig& map, int n, Rng& rng) {
  Vector3d p_W = test::RandomPoint(map, rng);
  if (n % 3 != 0) {
    p_W = (p_W / (map.width_m / 2)).array().round().matrix() * (map.width_m / 2);
  }
  Viewpoint view = UprightViewpoint(p_W, test::RandomDirection(rng));
  if (n % 2 == 0) {
    view.X_WS.linear().setIdentity();
  }
  return view;
}

RaySet Rays(const GainConfig& config, int n, Rng& rng) {
  RaySet rays = n % 4 == 0 ? RandomSphereRays(config, rng) : LatticeCameraRays(config);
  if (n % 4 == 2) {
    rays = {};
    for (int i = 0; i < 27; ++i) {
      static_cast<void>(rays.directions.push_back(Vector3d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
    }
  }
  return rays;
}

using GainRays = test::FanIsa;

INSTANTIATE_TEST_SUITE_P(Isa, GainRays, testing::Bool(), GainRays::Of);

TEST_P(GainRays, FindWhatOneWalkAfterTheOtherFinds) {
  const MapConfig map_config = test::SmallMapConfig();
  Rng rng(41);
  int unknown = 0;
  int uncovered = 0;
  int room = 0;
  for (const double occupied : {0.0, 0.02, 0.15}) {
    VoxelGrid map(map_config);
    test::Scatter(map, occupied, 0.5, rng);
    map.MarkCovered({0.2, 0.2, 0.2}, 0.2);
    map.SetResidual({3, 3, 3}, true);
    for (const double range_min_m : {0.0, 0.09}) {
      const GainConfig config{
          .range_m = 0.47, .range_min_m = range_min_m, .probe_radius_m = 0.3, .rays = 61};
      GainEvaluator gains(config, map_config);
      gains.Update(map);
      for (int n = 0; n < 300; ++n) {
        SCOPED_TRACE(testing::Message() << occupied << ", view " << n);
        const Viewpoint view = Place(map_config, n, rng);
        const RaySet rays = Rays(config, n, rng);
        const bool in_box = map.InBox(map.VoxelOf(view.p_WP));
        const Passed seen = Pass(map, view.X_WS, rays, config.range_m, range_min_m, test::Unknown);
        Isometry3d X_WP = Isometry3d::Identity();
        X_WP.translation() = view.p_WP;
        const Passed met = Pass(map, X_WP, rays, config.probe_radius_m, 0, test::Uncovered);
        const Passed beyond = Pass(map, view.X_WS, rays, 0.6, 0, Room);
        const ViewGain all = gains.Evaluate(view, rays, rays, GainCount::kPerRay);
        const ViewGain once = gains.Evaluate(view, rays, rays, GainCount::kDistinct);
        ASSERT_EQ(all.unknown_voxels, in_box ? seen.all : 0);
        ASSERT_EQ(all.uncovered_voxels, in_box ? met.all : 0);
        ASSERT_EQ(once.unknown_voxels, in_box ? std::ssize(seen.distinct) : 0);
        ASSERT_EQ(once.uncovered_voxels, in_box ? std::ssize(met.distinct) : 0);
        ASSERT_EQ(gains.RoomCount(view.X_WS, rays, 0.6), in_box ? std::ssize(beyond.distinct) : 0);
        unknown += all.unknown_voxels;
        uncovered += all.uncovered_voxels;
        room += static_cast<int>(beyond.distinct.size());
      }
    }
  }
  EXPECT_GT(unknown, 10000);
  EXPECT_GT(uncovered, 1000);
  EXPECT_GT(room, 10000);
}

TEST_P(GainRays, NoRaysFindNothing) {
  VoxelGrid map(test::SmallMapConfig());
  GainEvaluator gains(GainConfig{}, map.config());
  gains.Update(map);
  const Viewpoint view = UprightViewpoint({0.2, 0.2, 0.2}, Vector3d::UnitX());
  EXPECT_EQ(gains.Evaluate(view, {}, {}, GainCount::kDistinct).unknown_voxels, 0);
  EXPECT_EQ(gains.Evaluate(view, {}, {}, GainCount::kPerRay).unknown_voxels, 0);
}

}  // namespace
}  // namespace pipewright
