// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

/// Cells of the distance field, and its passes over rows of them.
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

/// Along x: to each of n cells the offset to the row's nearest obstacle, the left one of two;
/// kNoneInRow beyond the range. obstacle[x] is 0 or 1.
constexpr std::int8_t kNoneInRow = 127;
void SweepRow(const std::uint8_t* obstacle, int n, int range, std::int8_t* offsets);

/// Row `at` of `rows` rows that lie `stride` cells apart along an axis.
struct RowPlace {
  int at;
  int rows;
  int stride;
  int axis;
};

/// Along y or z: best[x] = the least of from[x + off stride] + Shifted(off, axis) over the rows
/// that there are, |off| <= range.
void MergeRows(const Packed* from, const RowPlace& place, int n, int range, Packed* best);

/// A row that was `before` and is `now` to one that lies `shift` from it: to[x] becomes the nearer.
/// @returns whether a cell stood on what is no more, so that it must be merged anew
bool Offer(const Packed* before, const Packed* now, Packed shift, int n, Packed* to);

}  // namespace pipewright::distance_cell
