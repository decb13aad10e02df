// SPDX-License-Identifier: MIT
#include "plan/gain/gain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "perception/map/ray_walk.h"
#include "tests/plan/gain/gain_fixture.h"

namespace pipewright {
namespace {

using test::Gain;

constexpr double kLn2 = std::numbers::ln2;

/// Where the ray is within the voxel's box, by slabs; nothing when it misses it.
struct Passage {
  double in;
  double out;
  VoxelIndex voxel;
};

std::optional<Passage> Pass(const Vector3d& origin, const Vector3d& direction, double range,
                            const VoxelIndex& v, double width) {
  const Vector3d lo = width * Vector3d(v.x, v.y, v.z);
  double in = 0;
  double out = range;
  for (int i = 0; i < 3; ++i) {
    const double a = (lo[i] - origin[i]) / direction[i];
    const double b = (lo[i] + width - origin[i]) / direction[i];
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  return in < out ? std::optional(Passage{in, out, v}) : std::nullopt;
}

/// The definition, in no hurry: all voxels of the box that the ray meets, sorted, looked at in
/// turn.
std::vector<VoxelIndex> Along(const VoxelGrid& map, const Vector3d& origin,
                              const Vector3d& direction, double range) {
  std::vector<Passage> passages;
  test::ForEachVoxel(map.config().lo, map.config().hi, [&](const VoxelIndex& v) {
    if (const auto p = Pass(origin, direction, range, v, map.config().width_m)) {
      passages.push_back(*p);
    }
  });
  std::sort(passages.begin(), passages.end(),
            [](const Passage& a, const Passage& b) { return a.in < b.in; });
  std::vector<VoxelIndex> voxels;
  for (const Passage& p : passages) {
    voxels.push_back(p.voxel);
    if (map.State(p.voxel) == VoxelState::kOccupied) {
      break;
    }
  }
  return voxels;
}

ViewGain BruteForce(const VoxelGrid& map, const GainConfig& config, const Viewpoint& view,
                    const RaySet& camera, const RaySet& probe, GainCount how) {
  std::set<int> seen;
  ViewGain gain;
  const auto count = [&](const VoxelIndex& v) {
    return how == GainCount::kPerRay || seen.insert(map.IndexOf(v)).second ? 1 : 0;
  };
  for (const Vector3d& d : camera.directions) {
    for (const VoxelIndex& v :
         Along(map, view.X_WS.translation(), view.X_WS.linear() * d, config.range_m)) {
      gain.unknown_voxels += test::Unknown(map, v) ? count(v) : 0;
    }
  }
  for (const Vector3d& d : probe.directions) {
    for (const VoxelIndex& v : Along(map, view.p_WP, d, config.probe_radius_m)) {
      gain.uncovered_voxels += test::Uncovered(map, v) ? count(v) : 0;
    }
  }
  gain.visual_nats = kLn2 * gain.unknown_voxels;
  gain.coverage_nats = kLn2 * gain.uncovered_voxels;
  return gain;
}

TEST_F(Gain, EqualsItsDefinitionOnRandomMapsInBothCounts) {
  for (const double occupied : {0.0, 0.03, 0.2}) {
    VoxelGrid map(map_config_);
    test::Scatter(map, occupied, 0.4, rng_);
    map.MarkCovered({0.2, 0.2, 0.2}, 0.2);
    map.SetResidual({3, 3, 3}, true);
    GainEvaluator gains(config_, map_config_);
    gains.Update(map);
    for (int i = 0; i < 12; ++i) {
      const Viewpoint view =
          UprightViewpoint(test::RandomPoint(map_config_, rng_), test::RandomDirection(rng_));
      const RaySet camera = RandomCameraRays(config_, rng_);
      const RaySet probe = RandomSphereRays(config_, rng_);
      for (const GainCount how : {GainCount::kPerRay, GainCount::kDistinct}) {
        SCOPED_TRACE(testing::Message() << "occupied " << occupied << ", view " << i);
        const ViewGain gain = gains.Evaluate(view, camera, probe, how);
        const ViewGain expected = BruteForce(map, config_, view, camera, probe, how);
        EXPECT_EQ(gain.unknown_voxels, expected.unknown_voxels);
        EXPECT_EQ(gain.uncovered_voxels, expected.uncovered_voxels);
        EXPECT_DOUBLE_EQ(gain.visual_nats, expected.visual_nats);
        EXPECT_DOUBLE_EQ(gain.coverage_nats, expected.coverage_nats);
      }
    }
  }
}

TEST_F(Gain, ExactCoverageIsWhatTheMapWouldMarkCovered) {
  test::Scatter(map_, 0.08, 0.3, rng_);
  GainEvaluator gains(config_, map_config_);
  int marked = 0;
  int apart = 0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d p_WP = test::RandomPoint(map_config_, rng_);
    gains.Update(map_);
    Viewpoint view;
    view.p_WP = p_WP;
    view.X_WS.translation() = p_WP;
    const int counted = gains.EvaluateExact(view, RaySet{}).uncovered_voxels;
    VoxelGrid after = map_;
    const int covered = after.MarkCovered(p_WP, config_.probe_radius_m);
    marked += covered;
    apart += std::abs(counted - covered);
  }
  EXPECT_GT(marked, 1000);
  // The map takes directions in float, as OctoMap does: a ray along an edge may fall to either
  // side.
  EXPECT_LE(apart, marked / 200);
}

TEST_F(Gain, SightIsTheMapsRay) {
  test::Scatter(map_, 0.05, 0.3, rng_);
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  const auto clear = [&](const Vector3d& p_W, const Vector3d& q_W, const VoxelIndex& target) {
    const bool through_unknown = map_.State(target) != VoxelState::kFree;
    for (RayWalk ray(map_, p_W.cast<float>(), q_W.cast<float>()); ray.Next();) {
      if (ray.voxel() == target) {
        return true;
      }
      if (map_.State(ray.voxel()) == VoxelState::kOccupied ||
          (!through_unknown && map_.State(ray.voxel()) == VoxelState::kUnknown)) {
        return false;
      }
    }
    return true;
  };
  int seen = 0;
  int apart = 0;
  for (int i = 0; i < 500; ++i) {
    const Vector3d p_W = test::RandomPoint(map_config_, rng_);
    const VoxelIndex target = map_.VoxelOf(test::RandomPoint(map_config_, rng_));
    const Vector3d center = map_.Center(target);
    bool sight = clear(p_W, center, target);
    for (int axis = 0; axis < 3; ++axis) {
      const double away = p_W[axis] - center[axis];
      Vector3d face = center;
      face[axis] += (away > 0 ? 0.499 : -0.499) * map_config_.width_m;
      sight = sight || (std::abs(away) > map_config_.width_m / 2 && clear(p_W, face, target));
    }
    seen += sight ? 1 : 0;
    apart += gains.InSight(p_W, target) == sight ? 0 : 1;
  }
  EXPECT_GT(seen, 50);
  EXPECT_LE(apart, 5);  // edges, in float and in double
}

TEST_F(Gain, SolidVoxelsAreSurfaceThoughFreeOnlyWhenAsked) {
  for (int i = 0; i < 4; ++i) {
    test::SetOccupied(map_, {5, 5, 4});
  }
  while (map_.State({5, 5, 4}) != VoxelState::kFree) {
    test::SetFree(map_, {5, 5, 4});
  }
  test::SetFree(map_, {4, 5, 4});
  test::SetFree(map_, {3, 5, 4});
  Viewpoint view;
  view.p_WP = map_.Center({3, 5, 4});
  for (const bool solid : {false, true}) {
    config_.solid_surfaces = solid;
    GainEvaluator gains(config_, map_config_);
    gains.Update(map_);
    EXPECT_EQ(gains.EvaluateExact(view, RaySet{}).uncovered_voxels, solid ? 1 : 0);
  }
}

TEST_F(Gain, RayEndsAtItsSurface) {
  for (int x = 0; x <= 4; ++x) {
    test::SetFree(map_, {x, 5, 4});
  }
  test::SetOccupied(map_, {5, 5, 4});
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  RaySet ahead;
  ASSERT_TRUE(ahead.directions.push_back(Vector3d::UnitZ()));
  const Viewpoint view = UprightViewpoint({0.02, 0.27, 0.22}, Vector3d::UnitX());
  const ViewGain toward = gains.Evaluate(view, ahead, RaySet{}, GainCount::kPerRay);
  EXPECT_EQ(toward.unknown_voxels, 0);
  const Viewpoint aside = UprightViewpoint({0.02, 0.27, 0.22}, Vector3d::UnitY());
  // y = 0.27 + 0.45 ends in voxel 14, W in voxel 9: 6 to 9 are unknown.
  EXPECT_EQ(gains.Evaluate(aside, ahead, RaySet{}, GainCount::kPerRay).unknown_voxels, 4);
}

TEST_F(Gain, SurfaceNearerThanTheCamerasMinimumTellsNothing) {
  // From x = 0.02 through unknown voxels 1, 2 to a surface in voxel 3, at 0.13 m.
  test::SetFree(map_, {0, 5, 4});
  test::SetOccupied(map_, {3, 5, 4});
  RaySet ahead;
  ASSERT_TRUE(ahead.directions.push_back(Vector3d::UnitZ()));
  const Viewpoint view = UprightViewpoint({0.02, 0.27, 0.22}, Vector3d::UnitX());
  for (const auto& [range_min_m, expected] : {std::pair(0.0, 2), {0.12, 2}, {0.14, 0}}) {
    config_.range_min_m = range_min_m;
    GainEvaluator gains(config_, map_config_);
    gains.Update(map_);
    EXPECT_EQ(gains.Evaluate(view, ahead, RaySet{}, GainCount::kDistinct).unknown_voxels, expected)
        << range_min_m;
  }
}

TEST_F(Gain, OriginOutsideTheBoxOrNotFiniteGainsNothing) {
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  const RaySet camera = LatticeCameraRays(config_);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Vector3d& p_W :
       {Vector3d(9, 0.1, 0.1), Vector3d(nan, 0.1, 0.1), Vector3d(0, 0, -1e9)}) {
    const ViewGain gain = gains.EvaluateExact(UprightViewpoint(p_W, Vector3d::UnitX()), camera);
    EXPECT_EQ(gain.unknown_voxels, 0);
    EXPECT_EQ(gain.uncovered_voxels, 0);
  }
}

TEST_F(Gain, ErratumSignMakesCoverageWorthSeeking) {
  test::SetOccupied(map_, {5, 5, 4});
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  Viewpoint view = UprightViewpoint(map_.Center({3, 5, 4}), Vector3d::UnitX());
  const ViewGain gain = gains.EvaluateExact(view, RaySet{});
  EXPECT_DOUBLE_EQ(gain.coverage_nats, kLn2);
  EXPECT_DOUBLE_EQ(WeightedGain(config_, gain), 0.25 * kLn2);  // (23), beta 0.75
}

}  // namespace
}  // namespace pipewright
