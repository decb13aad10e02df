// SPDX-License-Identifier: MIT
#include "perception/map/distance_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "platform/core/latest.h"
#include "platform/core/rng.h"
#include "tests/perception/map/octomap_oracle.h"

namespace pipewright {
namespace {

constexpr double kWidth = 0.05;

// A free box with the given share of unknown and of occupied voxels in it.
VoxelGrid Scattered(const MapConfig& config, double occupied, double unknown, Rng* rng) {
  VoxelGrid grid(config);
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    const Vector3d center = grid.Center(v);
    const Vector3f point = center.cast<float>();
    const double u = rng->Uniform();
    if (u < occupied) {
      grid.InsertScan(&point, 1, point, -1);
    } else if (u > occupied + unknown) {
      grid.MarkSweptSphere(center, 0.001);
    }
  }
  return grid;
}

double BoxDistance(const VoxelGrid& grid, const VoxelIndex& v, const Vector3d& p) {
  return ((p - grid.Center(v)).cwiseAbs().array() - kWidth / 2).max(0.0).matrix().norm();
}

// The plain definition: every obstacle asked.
double BruteForce(const VoxelGrid& grid, const Vector3d& p) {
  double best = grid.config().field_range_m;
  for (int i = 0; i < grid.voxel_count(); ++i) {
    if (grid.ObstacleAt(i)) {
      best = std::min(best, BoxDistance(grid, grid.VoxelAt(i), p));
    }
  }
  return best;
}

double BruteForceColumn(const VoxelGrid& grid, double x, double y) {
  double best = grid.config().field_range_m;
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const Vector3d c = grid.Center(grid.VoxelAt(i));
    if (grid.ObstacleAt(i) && grid.config().column_lo_m <= c.z() &&
        c.z() <= grid.config().column_hi_m) {
      best = std::min(best, std::hypot(std::max(std::abs(x - c.x()) - kWidth / 2, 0.0),
                                       std::max(std::abs(y - c.y()) - kWidth / 2, 0.0)));
    }
  }
  return best;
}

struct Density {
  const char* name;
  double occupied;
  double unknown;
};

constexpr Density kDensities[] = {
    {"a few voxels", 0.0005, 0}, {"sparse", 0.005, 0.005}, {"cluttered", 0.05, 0.05},
    {"nothing at all", 0, 0},    {"nothing known", 0, 1},
};

MapConfig Cell() {
  MapConfig config;
  config.lo = config.workspace_lo = {-3, 2, -2};
  config.hi = config.workspace_hi = {18, 19, 16};  // three different lengths
  config.brick_capacity = BricksOfBox(config);
  return config;
}

Vector3d InBox(const MapConfig& c, Rng* rng) {
  return {rng->Uniform(c.lo.x, c.hi.x + 1) * kWidth, rng->Uniform(c.lo.y, c.hi.y + 1) * kWidth,
          rng->Uniform(c.lo.z, c.hi.z + 1) * kWidth};
}

TEST(DistanceField, NeverSaysLessThanTheTruthAndHardlyMore) {
  for (const Density& d : kDensities) {
    SCOPED_TRACE(d.name);
    Rng rng(5);
    const VoxelGrid grid = Scattered(Cell(), d.occupied, d.unknown, &rng);
    DistanceField field(grid.config());
    field.Update(grid);
    double most = 0;
    for (int n = 0; n < 2000; ++n) {
      const Vector3d p = InBox(grid.config(), &rng);
      const double truth = BruteForce(grid, p);
      const double said = field.Distance(p);
      ASSERT_GE(said, truth - 1e-12);
      most = std::max(most, said - truth);
      if (truth < kWidth) {
        ASSERT_NEAR(said, truth, 1e-12) << "near an obstacle the field is exact";
      }
      ASSERT_LE(field.DistanceAtLeast(p), truth + 1e-12);
      ASSERT_GE(field.DistanceAtLeast(p), truth - 2 * kWidth);
    }
    EXPECT_LE(most, 0.25 * kWidth);
  }
}

TEST(DistanceField, IsExactAtCellCentresUpToItsRange) {
  for (const double range_m : {0.2, 0.5, 1.5}) {
    SCOPED_TRACE(range_m);
    Rng rng(6);
    MapConfig config = Cell();
    config.field_range_m = range_m;
    const VoxelGrid grid = Scattered(config, 0.001, 0.0005, &rng);
    DistanceField field(config);
    field.Update(grid);
    for (int i = 0; i < grid.voxel_count(); i += 7) {
      const Vector3d p = grid.Center(grid.VoxelAt(i));
      EXPECT_NEAR(field.Distance(p), BruteForce(grid, p), 0.25 * kWidth);
    }
  }
}

TEST(DistanceField, ColumnsAreTheObstaclesInTheBasesWay) {
  for (const Density& d : kDensities) {
    SCOPED_TRACE(d.name);
    Rng rng(7);
    const VoxelGrid grid = Scattered(Cell(), d.occupied / 4, d.unknown / 4, &rng);
    DistanceField field(grid.config());
    field.Update(grid);
    for (int n = 0; n < 500; ++n) {
      const Vector3d p = InBox(grid.config(), &rng);
      const double truth = BruteForceColumn(grid, p.x(), p.y());
      const Nearest said = field.NearestColumn(p.x(), p.y());
      ASSERT_GE(said.distance_m, truth - 1e-12);
      ASSERT_LE(said.distance_m, truth + 0.25 * kWidth);
      if (said.any) {
        EXPECT_EQ(said.p_W.z(), 0);
        EXPECT_EQ(said.direction_W.z(), 0);
      }
    }
  }
}

TEST(DistanceField, TellsTheObstacleItMeans) {
  Rng rng(8);
  const VoxelGrid grid = Scattered(Cell(), 0.01, 0.01, &rng);
  DistanceField field(grid.config());
  field.Update(grid);
  for (int n = 0; n < 500; ++n) {
    const Vector3d p = InBox(grid.config(), &rng);
    const Nearest near = field.NearestObstacle(p);
    ASSERT_TRUE(near.any);
    EXPECT_TRUE(grid.Obstacle(near.voxel));
    EXPECT_EQ(near.unknown, grid.State(near.voxel) == VoxelState::kUnknown);
    EXPECT_NEAR((p - near.p_W).norm(), near.distance_m, 1e-12);
    EXPECT_NEAR(BoxDistance(grid, near.voxel, near.p_W), 0, 1e-12);
    if (near.distance_m > 0) {
      EXPECT_LT((near.p_W + near.distance_m * near.direction_W - p).norm(), 1e-12);
    } else {
      EXPECT_EQ(near.direction_W.norm(), 0);
    }
  }
}

TEST(DistanceField, FollowsTheMap) {
  VoxelGrid grid(Cell());
  DistanceField field(grid.config());
  const Vector3d p(0.3, 0.4, 0.3);
  field.Update(grid);
  EXPECT_EQ(field.Distance(p), 0) << "unknown is an obstacle";
  grid.MarkSweptSphere(p, 0.1);
  EXPECT_EQ(field.Distance(p), 0) << "not before the next update";
  field.Update(grid);
  EXPECT_NEAR(field.Distance(p), BruteForce(grid, p), 1e-12);
  EXPECT_GT(field.Distance(p), 0.1 - 1e-12);
  EXPECT_TRUE(field.NearestObstacle(p).unknown);
}

TEST(DistanceField, OutsideTheBoxIsFreeUnlessConfiguredAsAnObstacle) {
  MapConfig config = Cell();
  config.lo = config.workspace_lo = {0, 0, 0};
  config.hi = config.workspace_hi = {9, 9, 9};
  Rng rng(9);
  DistanceField free(config);
  free.Update(Scattered(config, 0, 0, &rng));
  EXPECT_FALSE(free.NearestObstacle({0.25, 0.25, 0.01}).any);
  EXPECT_EQ(free.Distance({0.25, 0.25, 0.01}), config.field_range_m);

  config.outside_is_obstacle = true;
  DistanceField walled(config);
  walled.Update(Scattered(config, 0, 0, &rng));
  EXPECT_NEAR(walled.Distance({0.25, 0.25, 0.01}), 0.01, 1e-12);
  EXPECT_NEAR(walled.Distance({0.42, 0.25, 0.25}), 0.08, 1e-12);
  EXPECT_LE(walled.DistanceAtLeast({0.42, 0.25, 0.25}), 0.08 + 1e-12);
  EXPECT_EQ(walled.Distance({0.25, 0.25, -0.3}), 0);
  EXPECT_NEAR(walled.NearestColumn(0.03, 0.25).distance_m, 0.03, 1e-12);
  EXPECT_TRUE(walled.NearestColumn(0.03, 0.25).unknown);
}

TEST(DistanceField, KnowingNothingItSaysZero) {
  const DistanceField empty;
  EXPECT_TRUE(empty.empty());
  EXPECT_EQ(empty.Distance({1, 2, 3}), 0);
  EXPECT_EQ(empty.DistanceAtLeast({1, 2, 3}), 0);
  EXPECT_TRUE(empty.NearestColumn(1, 2).unknown);
  const DistanceField never_updated(Cell());
  EXPECT_EQ(never_updated.Distance({0.3, 0.4, 0.3}), 0);
  EXPECT_EQ(never_updated.Distance({std::nan(""), 0.4, 0.3}), 0);
}

TEST(DistanceField, PassesThroughLatest) {
  Rng rng(10);
  const VoxelGrid grid = Scattered(Cell(), 0.01, 0, &rng);
  DistanceField field(grid.config());
  field.Update(grid);
  Latest<DistanceField> latest;
  EXPECT_TRUE(latest.Read().empty());
  latest.Write(field);
  const Vector3d p(0.3, 0.4, 0.3);
  EXPECT_EQ(latest.Read().Distance(p), field.Distance(p));
}

}  // namespace
}  // namespace pipewright
