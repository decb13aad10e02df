// SPDX-License-Identifier: MIT
#pragma once

#include "tests/bench/map_scenes.h"

namespace pipewright::bench {

/// What DistanceField::Update costs in a cell of 40 x 40 x 40 voxels; nobody to compare with.
struct FieldTimes {
  double one_voxel_ms = 0;  ///< after one voxel anywhere turned free, or back
  double one_scan_ms = 0;   ///< after each of the scene's scans, on the mean
  double all_cells_ms = 0;  ///< all cells anew, on the mean over the maps after those scans
};

FieldTimes TimeField(MapScene scene, int passes);

}  // namespace pipewright::bench
