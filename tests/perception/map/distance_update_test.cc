// SPDX-License-Identifier: MIT
// The distance field as the map changes, and between the centres of its cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/map/distance_field.h"
#include "platform/core/rng.h"
#include "tests/perception/map/octomap_oracle.h"

namespace pipewright {
namespace {

constexpr double kWidth = 0.05;

MapConfig Cell(double range_m) {
  MapConfig config;
  config.lo = config.workspace_lo = {-3, 2, -2};
  config.hi = config.workspace_hi = {16, 19, 12};  // no multiple of a brick, nor of one another
  config.brick_capacity = BricksOfBox(config);
  config.field_range_m = range_m;
  return config;
}

Vector3d Somewhere(const MapConfig& c, double margin, Rng* rng) {
  const auto draw = [&](int lo, int hi) {
    return rng->Uniform(lo * kWidth - margin, (hi + 1) * kWidth + margin);
  };
  const double x = draw(c.lo.x, c.hi.x);
  const double y = draw(c.lo.y, c.hi.y);
  return {x, y, draw(c.lo.z, c.hi.z)};
}

// One of the ways in which a map changes, from one voxel to most of them.
void ChangeSomething(VoxelGrid* grid, Rng* rng) {
  const MapConfig& config = grid->config();
  switch (rng->Index(4)) {
    case 0: {
      std::vector<Vector3f> points;
      const int count = 1 + rng->Index(20);
      for (int i = 0; i < count; ++i) {
        points.emplace_back(Somewhere(config, 0.2, rng).cast<float>());
      }
      grid->InsertScan(points.data(), count, Somewhere(config, 0.1, rng).cast<float>(), 0.6);
      return;
    }
    case 1:
      grid->MarkSweptSphere(Somewhere(config, 0, rng), rng->Uniform(0, 0.25));
      return;
    case 2:
      grid->Restore(grid->VoxelAt(rng->Index(grid->voxel_count())), 1);
      return;
    default:
      grid->Restore(grid->VoxelAt(rng->Index(grid->voxel_count())), -1);
  }
}

// The plain definition at a cell: all obstacles asked for the distance of their centre.
double BruteForce(const VoxelGrid& grid, const std::vector<VoxelIndex>& obstacles,
                  const Vector3d& p_W) {
  double squared = grid.config().field_range_m * grid.config().field_range_m;
  for (const VoxelIndex& v : obstacles) {
    squared = std::min(squared, (grid.Center(v) - p_W).squaredNorm());
  }
  return std::sqrt(squared);
}

std::vector<VoxelIndex> Obstacles(const VoxelGrid& grid) {
  std::vector<VoxelIndex> obstacles;
  for (int i = 0; i < grid.voxel_count(); ++i) {
    if (grid.ObstacleAt(i)) {
      obstacles.push_back(grid.VoxelAt(i));
    }
  }
  return obstacles;
}

struct Start {
  const char* name;
  double free;  ///< share of voxels that are swept free before anything changes
  double range_m;
};

constexpr Start kStarts[] = {
    {"nothing known", 0, 0.5},
    {"half free", 0.5, 0.2},
    {"nearly all free", 0.995, 0.5},
    {"all free", 1, 1.5},
};

VoxelGrid GridOf(const Start& start, Rng* rng) {
  VoxelGrid grid(Cell(start.range_m));
  for (int i = 0; i < grid.voxel_count(); ++i) {
    if (rng->Uniform() < start.free) {
      grid.MarkSweptSphere(grid.Center(grid.VoxelAt(i)), 0.001);
    }
  }
  return grid;
}

TEST(DistanceFieldUpdate, IsTheWholeFieldAndTheDefinitionAfterEveryChange) {
  for (const Start& start : kStarts) {
    SCOPED_TRACE(start.name);
    Rng rng(21);
    VoxelGrid grid = GridOf(start, &rng);
    DistanceField field(grid.config());
    for (int step = 0; step < 120; ++step) {
      SCOPED_TRACE(step);
      const int changes = step % 3 == 0 ? 1 + rng.Index(6) : 1;
      for (int i = 0; i < changes; ++i) {
        ChangeSomething(&grid, &rng);
      }
      field.Update(grid);
      DistanceField whole(grid.config());
      whole.Update(grid);
      ASSERT_TRUE(field == whole);
      const std::vector<VoxelIndex> obstacles = Obstacles(grid);
      for (int i = step % 11; i < grid.voxel_count(); i += 11) {
        const Vector3d center_W = grid.Center(grid.VoxelAt(i));
        ASSERT_NEAR(field.Interpolate(center_W).distance_m, BruteForce(grid, obstacles, center_W),
                    1e-9);
      }
    }
  }
}

TEST(DistanceFieldUpdate, FollowsAVoxelThatComesAndGoesOneAtATime) {
  Rng rng(22);
  VoxelGrid grid = GridOf(kStarts[2], &rng);
  DistanceField field(grid.config());
  field.Update(grid);
  for (int step = 0; step < 300; ++step) {
    const VoxelIndex v = grid.VoxelAt(rng.Index(grid.voxel_count()));
    for (const float log_odds : {0.1F, -0.1F}) {
      grid.Restore(v, log_odds);
      field.Update(grid);
      DistanceField whole(grid.config());
      whole.Update(grid);
      ASSERT_TRUE(field == whole) << "step " << step;
    }
  }
}

TEST(DistanceFieldUpdate, OfACopyIsThatOfTheFieldItself) {
  Rng rng(23);
  VoxelGrid grid = GridOf(kStarts[1], &rng);
  DistanceField field(grid.config());
  field.Update(grid);
  DistanceField copy = field;
  DistanceField assigned;
  assigned = field;
  EXPECT_TRUE(copy == field);
  for (int step = 0; step < 3; ++step) {
    ChangeSomething(&grid, &rng);
    field.Update(grid);
    copy.Update(grid);
    assigned.Update(grid);
    EXPECT_TRUE(copy == field);
    EXPECT_TRUE(assigned == field);
  }
}

TEST(DistanceFieldUpdate, SeesADifferenceOfOneCell) {
  VoxelGrid grid(Cell(0.5));
  DistanceField one(grid.config());
  one.Update(grid);
  DistanceField other = one;
  EXPECT_TRUE(one == other);
  grid.Restore({0, 5, 0}, -1);
  other.Update(grid);
  EXPECT_FALSE(one == other);
}

TEST(SmoothDistance, GradientIsThatOfTheDistanceByFiniteDifferences) {
  constexpr double kStep_m = 1e-4 * kWidth;
  for (const bool walls : {false, true}) {
    Rng rng(24);
    VoxelGrid grid = GridOf(kStarts[2], &rng);
    MapConfig config = grid.config();
    config.outside_is_obstacle = walls;
    DistanceField field(config);
    field.Update(grid);
    int compared = 0;
    for (int n = 0; n < 3000; ++n) {
      const Vector3d p_W = Somewhere(config, 0.15, &rng);
      const SmoothDistance at = field.Interpolate(p_W);
      for (int axis = 0; axis < 3; ++axis) {
        const double in_cube = p_W[axis] / kWidth - 0.5 - std::floor(p_W[axis] / kWidth - 0.5);
        if (in_cube < 1e-3 || in_cube > 1 - 1e-3) {
          continue;  // the gradient jumps between two cubes
        }
        const Vector3d step = kStep_m * Vector3d::Unit(axis);
        const double difference =
            (field.Interpolate(p_W + step).distance_m - field.Interpolate(p_W - step).distance_m) /
            (2 * kStep_m);
        // Along one axis the polynomial is straight: what differs is rounding, 1e-16 / 5e-6.
        ASSERT_NEAR(at.gradient_W[axis], difference, 1e-9);
        ASSERT_LE(std::abs(at.gradient_W[axis]), 1 + 1e-12);
        ++compared;
      }
    }
    EXPECT_GT(compared, 8000);
  }
}

TEST(SmoothDistance, IsWithinItsBoundOfTheDistanceBetweenCentres) {
  Rng rng(25);
  const VoxelGrid grid = GridOf(kStarts[2], &rng);
  const std::vector<VoxelIndex> obstacles = Obstacles(grid);
  DistanceField field(grid.config());
  field.Update(grid);
  for (int n = 0; n < 2000; ++n) {
    const Vector3d p_W = Somewhere(grid.config(), -kWidth / 2, &rng);
    ASSERT_NEAR(field.Interpolate(p_W).distance_m, BruteForce(grid, obstacles, p_W),
                std::sqrt(3.0) / 2 * kWidth + 1e-12);
  }
}

TEST(SmoothDistance, GoesOnOutsideTheBoxUnlessThereAreWalls) {
  MapConfig config = Cell(0.5);
  Rng rng(26);
  const VoxelGrid grid = GridOf(kStarts[3], &rng);
  config.field_range_m = grid.config().field_range_m;
  DistanceField open(config);
  open.Update(grid);
  config.outside_is_obstacle = true;
  DistanceField walled(config);
  walled.Update(grid);
  const Vector3d first_W = grid.Center(config.lo);
  EXPECT_EQ(open.Interpolate(first_W).distance_m, config.field_range_m);
  EXPECT_NEAR(walled.Interpolate(first_W).distance_m, kWidth, 1e-12);
  EXPECT_NEAR(walled.Interpolate(first_W + Vector3d(0.1, 0.2, 0.05)).gradient_W.z(), 1, 1e-12);
  for (const Vector3d& far_W : {Vector3d(-1e9, 0.3, 0.1), Vector3d(0.2, 50, 0.1)}) {
    EXPECT_EQ(open.Interpolate(far_W).distance_m, config.field_range_m);
    EXPECT_EQ(open.Interpolate(far_W).gradient_W, Vector3d::Zero());
    EXPECT_EQ(walled.Interpolate(far_W).distance_m, 0);
    EXPECT_EQ(walled.Interpolate(far_W).gradient_W, Vector3d::Zero());
  }
}

TEST(SmoothDistance, OfAFieldThatKnowsNothingOrOfNoPointIsZero) {
  const DistanceField empty;
  EXPECT_EQ(empty.Interpolate({1, 2, 3}).distance_m, 0);
  const DistanceField never_updated(Cell(0.5));
  EXPECT_EQ(never_updated.Interpolate({0.3, 0.4, 0.3}).distance_m, 0);
  EXPECT_EQ(never_updated.Interpolate({std::nan(""), 0.4, 0.3}).distance_m, 0);
}

}  // namespace
}  // namespace pipewright
