// SPDX-License-Identifier: MIT
#include "tests/bench/map_field.h"

#include "perception/map/distance_field.h"
#include "platform/core/rng.h"
#include "tests/bench/stopwatch.h"

namespace pipewright::bench {

FieldTimes TimeField(MapScene scene, int passes) {
  constexpr int kVoxels = 100;
  scene.config.lo = {-5, -5, -5};
  scene.config.hi = {34, 34, 34};
  scene.config.brick_capacity = BricksOfBox(scene.config);
  const DistanceField never_updated(scene.config);
  Stopwatch one_voxel;
  Stopwatch one_scan;
  Stopwatch all_cells;
  for (int pass = 0; pass < passes; ++pass) {
    VoxelGrid grid(scene.config);
    DistanceField field(scene.config);
    field.Update(grid);
    for (std::size_t scan = 0; scan < scene.scans.size(); ++scan) {
      test::InsertOurs(&grid, scene.scans[scan]);
      one_scan.Time(scan, [&] { field.Update(grid); });
      DistanceField anew = never_updated;
      all_cells.Time(scan, [&] { anew.Update(grid); });
    }
    Rng rng(1);
    for (int i = 0; i < kVoxels; ++i) {
      const VoxelIndex v = grid.VoxelAt(rng.Index(grid.voxel_count()));
      grid.Restore(v, -1);
      field.Update(grid);
      grid.Restore(v, 1);
      one_voxel.Time(2 * i, [&] { field.Update(grid); });
      grid.Restore(v, -1);
      one_voxel.Time(2 * i + 1, [&] { field.Update(grid); });
    }
  }
  const auto scans = static_cast<double>(scene.scans.size());
  return {1e3 * one_voxel.least_s() / (2 * kVoxels), 1e3 * one_scan.least_s() / scans,
          1e3 * all_cells.least_s() / scans};
}

}  // namespace pipewright::bench
