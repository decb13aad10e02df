// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "perception/map/voxel_grid.h"

namespace pipewright::hil {

/// A map's box as a window that follows the sensor: bricks that leave it are kept here, on the heap
/// as a robot would on disk, and those that it comes back to are taken in again.
class MapWindow {
 public:
  using Key = std::array<int, 3>;  ///< z y x of a brick's first voxel: the order of a map's voxels

  /// The box of `grid` is of WholeBricks, and the grid has a brick for each.
  explicit MapWindow(VoxelGrid& grid) : grid_(grid) {}

  /// Moves the window until its middle is within half a brick of P.
  void Follow(const Vector3d& p_W);

  const std::map<Key, BrickVoxels>& left() const { return left_; }
  int moves() const { return moves_; }
  std::int64_t known_outside() const;  ///< voxels of left()

 private:
  void TakeIn();

  VoxelGrid& grid_;
  std::map<Key, BrickVoxels> left_;
  int moves_ = 0;
};

/// Voxels of a window with sides of at least side_m, in whole bricks, anywhere.
VoxelBox WindowBox(double side_m, double width_m);

}  // namespace pipewright::hil
