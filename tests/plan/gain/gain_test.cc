// SPDX-License-Identifier: MIT
#include "plan/gain/gain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "perception/map/ray_walk.h"
#include "tests/plan/gain/toy_map.h"

namespace pipewright {
namespace {

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

bool Unknown(const VoxelGrid& map, const VoxelIndex& v) {
  return map.InWorkspace(v) && map.State(v) == VoxelState::kUnknown && !map.Residual(v);
}

bool Uncovered(const VoxelGrid& map, const VoxelIndex& v) {
  return map.InWorkspace(v) && map.State(v) == VoxelState::kOccupied && !map.Covered(v);
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
      gain.unknown_voxels += Unknown(map, v) ? count(v) : 0;
    }
  }
  for (const Vector3d& d : probe.directions) {
    for (const VoxelIndex& v : Along(map, view.p_WP, d, config.probe_radius_m)) {
      gain.uncovered_voxels += Uncovered(map, v) ? count(v) : 0;
    }
  }
  gain.visual_nats = kLn2 * gain.unknown_voxels;
  gain.coverage_nats = kLn2 * gain.uncovered_voxels;
  return gain;
}

Vector3d RandomPoint(const MapConfig& config, Rng& rng) {
  const auto draw = [&](int lo, int hi) { return config.width_m * rng.Uniform(lo, hi + 1); };
  const double x = draw(config.lo.x, config.hi.x);
  const double y = draw(config.lo.y, config.hi.y);
  return {x, y, draw(config.lo.z, config.hi.z)};
}

Vector3d RandomDirection(Rng& rng) {
  const double x = rng.Normal();
  const double y = rng.Normal();
  return Vector3d(x, y, rng.Normal()).normalized();
}

class Gain : public testing::Test {
 protected:
  MapConfig map_config_ = test::SmallMapConfig();
  VoxelGrid map_{map_config_};
  GainConfig config_{.range_m = 0.45, .probe_radius_m = 0.3, .rays = 60};
  Rng rng_{7};
};

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
          UprightViewpoint(RandomPoint(map_config_, rng_), RandomDirection(rng_));
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
    const Vector3d p_WP = RandomPoint(map_config_, rng_);
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
    const Vector3d p_W = RandomPoint(map_config_, rng_);
    const VoxelIndex target = map_.VoxelOf(RandomPoint(map_config_, rng_));
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

TEST_F(Gain, ListsHoldFrontierUncoveredAndUnknownVoxels) {
  test::Scatter(map_, 0.1, 0.5, rng_);
  map_.MarkCovered({0.25, 0.25, 0.2}, 0.2);
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  std::vector<VoxelIndex> frontier;
  std::vector<VoxelIndex> uncovered;
  std::vector<VoxelIndex> unknown;
  test::ForEachVoxel(map_config_.workspace_lo, map_config_.workspace_hi, [&](const VoxelIndex& v) {
    const VoxelIndex beside[] = {{v.x - 1, v.y, v.z}, {v.x + 1, v.y, v.z}, {v.x, v.y - 1, v.z},
                                 {v.x, v.y + 1, v.z}, {v.x, v.y, v.z - 1}, {v.x, v.y, v.z + 1}};
    const bool by_free = std::any_of(std::begin(beside), std::end(beside), [&](const auto& n) {
      return map_.State(n) == VoxelState::kFree;
    });
    if (Uncovered(map_, v)) {
      uncovered.push_back(v);
    }
    if (Unknown(map_, v)) {
      unknown.push_back(v);
    }
    if (Unknown(map_, v) && by_free) {
      frontier.push_back(v);
    }
  });
  EXPECT_TRUE(std::ranges::equal(gains.Frontier(), frontier));
  EXPECT_TRUE(std::ranges::equal(gains.Uncovered(), uncovered));
  EXPECT_TRUE(std::ranges::equal(gains.Unknown(), unknown));
}

TEST_F(Gain, IgnoredVoxelsNeitherCountNorAreListed) {
  test::Scatter(map_, 0.1, 0.5, rng_);
  GainEvaluator gains(config_, map_config_);
  const std::vector<std::uint8_t> all(static_cast<std::size_t>(gains.workspace_voxels()), 1);
  gains.Update(map_, all);
  EXPECT_TRUE(gains.Frontier().empty());
  EXPECT_TRUE(gains.Uncovered().empty());
  const Viewpoint view = UprightViewpoint({0.25, 0.25, 0.2}, Vector3d::UnitX());
  const ViewGain gain = gains.EvaluateExact(view, LatticeCameraRays(config_));
  EXPECT_EQ(gain.unknown_voxels + gain.uncovered_voxels, 0);
}

TEST_F(Gain, TallyMarksExactlyWhatCounts) {
  test::Scatter(map_, 0.05, 0.4, rng_);
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  const RaySet camera = LatticeCameraRays(config_);
  for (int i = 0; i < 20; ++i) {
    const Viewpoint view = UprightViewpoint(RandomPoint(map_config_, rng_), RandomDirection(rng_));
    std::vector<std::uint8_t> tally(static_cast<std::size_t>(gains.workspace_voxels()), 0);
    gains.Tally(view, camera, tally);
    const ViewGain gain = gains.EvaluateExact(view, camera);
    EXPECT_EQ(std::count(tally.begin(), tally.end(), 1),
              gain.unknown_voxels + gain.uncovered_voxels);
    gains.Update(map_, tally);
    const ViewGain after = gains.EvaluateExact(view, camera);
    EXPECT_EQ(after.unknown_voxels + after.uncovered_voxels, 0);
    gains.Update(map_);
  }
}

TEST_F(Gain, TallyOnAWayMarksEachVoxelOnceThatTheWayGains) {
  test::Scatter(map_, 0.05, 0.4, rng_);
  GainEvaluator gains(config_, map_config_);
  gains.Update(map_);
  const RaySet camera = LatticeCameraRays(config_);
  std::vector<Viewpoint> way;
  for (int i = 0; i < 5; ++i) {
    way.push_back(UprightViewpoint(RandomPoint(map_config_, rng_), RandomDirection(rng_)));
  }
  int gained = 0;
  gains.BeginWay();
  for (const Viewpoint& view : way) {
    const ViewGain gain = gains.NextOnWay(view, camera);
    gained += gain.unknown_voxels + gain.uncovered_voxels;
  }
  std::vector<std::uint8_t> tally(static_cast<std::size_t>(gains.workspace_voxels()), 0);
  gains.BeginWay();
  for (const Viewpoint& view : way) {
    gains.TallyOnWay(view, camera, tally);
  }
  EXPECT_GT(gained, 0);
  EXPECT_EQ(std::count(tally.begin(), tally.end(), 1), gained);
  EXPECT_EQ(*std::max_element(tally.begin(), tally.end()), 1);
}

TEST(UprightViewpoint, LooksAlongItsAxisWithTheImageUpright) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Vector3d z_WS = RandomDirection(rng);
    const Matrix3d R = UprightViewpoint({1, 2, 3}, z_WS).X_WS.linear();
    EXPECT_NEAR((R * R.transpose() - Matrix3d::Identity()).norm(), 0, 1e-12);
    EXPECT_NEAR(R.determinant(), 1, 1e-12);
    EXPECT_EQ(R.col(2), z_WS);
    EXPECT_NEAR(R(2, 0), 0, 1e-12);  // x_S is horizontal
    EXPECT_LE(R(2, 1), 1e-12);       // y_S points down
  }
  for (const double up : {1.0, -1.0}) {
    const Matrix3d R = UprightViewpoint({0, 0, 0}, {0, 0, up}).X_WS.linear();
    EXPECT_EQ(R.col(0), Vector3d(0, -1, 0));
    EXPECT_NEAR(R.determinant(), 1, 1e-12);
  }
}

TEST(RaySets, LieWithinTheFieldOfViewAndFillIt) {
  const GainConfig config;
  Rng rng(5);
  for (const RaySet& rays : {RandomCameraRays(config, rng), LatticeCameraRays(config)}) {
    ASSERT_EQ(rays.directions.size(), config.rays);
    double x_max = 0;
    double y_max = 0;
    for (const Vector3d& d : rays.directions) {
      EXPECT_NEAR(d.norm(), 1, 1e-12);
      x_max = std::max(x_max, std::abs(std::atan2(d.x(), d.z())));
      y_max = std::max(y_max, std::abs(std::atan2(d.y(), d.z())));
    }
    EXPECT_LE(x_max, config.fov_x_rad / 2 + 1e-12);
    EXPECT_LE(y_max, config.fov_y_rad / 2 + 1e-12);
    EXPECT_GT(x_max, 0.9 * config.fov_x_rad / 2);
    EXPECT_GT(y_max, 0.9 * config.fov_y_rad / 2);
  }
}

TEST(RaySets, SphereRaysAreUnitVectorsWithoutAPreferredSide) {
  const GainConfig config{.rays = 512};
  Rng rng(6);
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& d : RandomSphereRays(config, rng).directions) {
    EXPECT_NEAR(d.norm(), 1, 1e-12);
    sum += d;
  }
  EXPECT_LT(sum.norm() / 512, 0.1);  // standard deviation of the mean: 1 / sqrt(512) = 0.044
}

}  // namespace
}  // namespace pipewright
