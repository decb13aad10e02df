// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "perception/map/voxel_grid.h"
#include "platform/core/status.h"

/// OctoMap files of a VoxelGrid, through liboctomap: they open in octovis and RViz. Host only.
///
/// Errors: kUnavailable, the file cannot be opened or written; kMalformed, it is no OctoMap file or
/// its voxels are of another width.
namespace pipewright {

/// .ot: every known voxel of the stored box with its log-odds; equal neighbours are pruned
/// together.
Status WriteOt(const VoxelGrid& grid, const std::string& path);

/// .bt: free or occupied, without log-odds.
Status WriteBt(const VoxelGrid& grid, const std::string& path);

/// How many voxels a file held inside and outside the grid's box. Those outside are left out.
struct OctomapFileStats {
  int restored = 0;
  int outside = 0;
  int refused = 0;  ///< for want of a brick
};

/// Reads .ot or .bt, told apart by the first line, into the grid: what it holds replaces what the
/// grid knew of that voxel. Voxels of a .bt get the sensor model's clamps as log-odds.
Result<OctomapFileStats> ReadOctomap(const std::string& path, VoxelGrid* grid);

}  // namespace pipewright
