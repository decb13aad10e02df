// SPDX-License-Identifier: MIT
#pragma once

#include "perception/map/voxel_grid.h"
#include "platform/core/rng.h"

namespace pipewright::test {

/// Makes one voxel occupied: a scan of one point at its own origin.
inline void SetOccupied(VoxelGrid& map, const VoxelIndex& v) {
  const Vector3f center = map.Center(v).cast<float>();
  map.InsertScan(&center, 1, center, -1);
}

/// Makes one voxel free: a ray of one width from its centre, towards a point out of range.
inline void SetFree(VoxelGrid& map, const VoxelIndex& v) {
  const Vector3f center = map.Center(v).cast<float>();
  const Vector3f far = center + Vector3f(10, 0, 0);
  map.InsertScan(&far, 1, center, map.config().width_m);
}

template <typename Visit>
void ForEachVoxel(const VoxelIndex& lo, const VoxelIndex& hi, Visit visit) {
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        visit(VoxelIndex{x, y, z});
      }
    }
  }
}

/// A small box with a W inside it, every third side flush with the box.
inline MapConfig SmallMapConfig() {
  MapConfig config;
  config.lo = {-3, -2, 0};
  config.hi = {12, 11, 9};
  config.workspace_lo = {0, 0, 0};
  config.workspace_hi = {9, 9, 7};
  config.brick_capacity = BricksOfBox(config);
  return config;
}

/// Shares of voxels, drawn one by one; the rest is free.
inline void Scatter(VoxelGrid& map, double occupied, double unknown, Rng& rng) {
  ForEachVoxel(map.config().lo, map.config().hi, [&](const VoxelIndex& v) {
    const double draw = rng.Uniform();
    if (draw < occupied) {
      SetOccupied(map, v);
    } else if (draw >= occupied + unknown) {
      SetFree(map, v);
    }
  });
}

}  // namespace pipewright::test
