// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bitset>

#include "perception/map/voxel_index.h"

namespace pipewright {

/// What a map knows of 8x8x8 voxels, x fastest. What is not known has log-odds 0.
struct BrickVoxels {
  static constexpr int kSide = 8;
  static constexpr int kVoxels = kSide * kSide * kSide;

  VoxelIndex lo;  ///< its first voxel; multiples of 8
  std::array<float, kVoxels> log_odds{};
  std::bitset<kVoxels> known;
  std::bitset<kVoxels> probed;  ///< and known; with log-odds of an occupied voxel: covered

  /// Of voxel (lo.x + x, lo.y + y, lo.z + z).
  static constexpr int IndexOf(int x, int y, int z) { return x + kSide * (y + kSide * z); }
  constexpr VoxelIndex VoxelAt(int i) const {
    return {lo.x + i % kSide, lo.y + i / kSide % kSide, lo.z + i / (kSide * kSide)};
  }
};

}  // namespace pipewright
