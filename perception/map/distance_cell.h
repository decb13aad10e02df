// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace pipewright::distance_cell {

/// A cell of the distance field is one number, so that the nearer of two obstacles is the smaller
/// of two integers, ties falling to the smaller offset. From the top:
///
///   squared distance (13 bits) | dz + 32 (6) | dy + 32 (6) | dx + 32 (6)
///
/// with (dx, dy, dz) from the cell to the obstacle, each within +-31 voxels.
using Packed = std::int32_t;

constexpr int kOffsetBits = 6;
constexpr int kBias = 1 << (kOffsetBits - 1);
constexpr int kDistanceShift = 3 * kOffsetBits;
constexpr Packed kHere = kBias | (kBias << kOffsetBits) | (kBias << 2 * kOffsetBits);
constexpr Packed kNone = 4095 << kDistanceShift;  // above 3 * 31^2, and two steps below overflow

constexpr Packed Shifted(int offset, int axis) {
  return (offset * offset << kDistanceShift) + offset * (1 << (axis * kOffsetBits));
}

constexpr int SquaredDistance(Packed cell) { return cell >> kDistanceShift; }

constexpr int Offset(Packed cell, int axis) {
  return ((cell >> (axis * kOffsetBits)) & (2 * kBias - 1)) - kBias;
}

}  // namespace pipewright::distance_cell
