// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "perception/map/voxel_grid.h"
#include "platform/core/status.h"

/// OctoMap files of a VoxelGrid: they open in octovis and RViz. Written through liboctomap, but
/// read by a reader of our own: a file that makes no sense must not lead to a stack without end, or
/// to as much memory as it claims. Host only.
///
/// Errors: kUnavailable, the file cannot be opened or written; kMalformed, it is no OctoMap file,
/// is not whole, or its voxels are of another width. The grid is then as before.
namespace pipewright {

/// .ot: every known voxel of the stored box with its log-odds; equal neighbours are pruned
/// together.
Status WriteOt(const VoxelGrid& grid, const std::string& path);

/// .bt: free or occupied, without log-odds.
Status WriteBt(const VoxelGrid& grid, const std::string& path);

/// How many voxels a file held inside and outside the grid's box. Those outside are left out.
struct OctomapFileStats {
  std::int64_t restored = 0;
  std::int64_t outside = 0;
  std::int64_t refused = 0;  ///< for want of a brick, or not a number
};

/// Reads .ot or .bt, told apart by the first line, both of octomap::OcTree alone, into the grid:
/// what it holds replaces what the grid knew of that voxel. Voxels of a .bt get the sensor model's
/// clamps as log-odds.
Result<OctomapFileStats> ReadOctomap(const std::string& path, VoxelGrid* grid);

}  // namespace pipewright
