// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "perception/map/voxel_index.h"

namespace pipewright {

/// The voxels that the scan in hand can reach, two bits each: passed by a ray, and hit. Rows along
/// x begin and end with whole bytes, a byte being the eight voxels of a brick's row.
class ScanWindow {
 public:
  /// Room for any window within the box.
  explicit ScanWindow(const MapConfig& box);

  /// The voxels lo to hi, inclusive; none when lo > hi. All bits must be clear.
  void Open(const VoxelIndex& lo, const VoxelIndex& hi);

  bool Contains(const VoxelIndex& v) const { return Within(v, lo_, hi_); }
  /// Flat index of a voxel of the window.
  int IndexOf(const VoxelIndex& v) const {
    return v.x - row_lo_x_ + row_voxels_ * (v.y - lo_.y + rows_ * (v.z - lo_.z));
  }
  int stride_y() const { return row_voxels_; }
  int stride_z() const { return row_voxels_ * rows_; }

  void SetHit(int index) { Set(hits_, index); }
  void SetPassed(int index) { Set(passed_, index); }
  /// Sets those of n bits whose index is not negative, and calls fresh(i) for each that was not
  /// set.
  /// @returns how many are not negative
  template <typename Fresh>
  int SetHits(const std::int32_t* index, int n, Fresh fresh);
  std::uint32_t* passed() { return passed_.data(); }
  void ClearHits();

  /// Calls visit(v, hits, passed) for each row of eight voxels from v on that has a bit in either;
  /// bit i is of v.x + i. Clears those that it visits.
  template <typename Visit>
  void TakeRows(Visit visit);

  std::int64_t MemoryBytes() const;

 private:
  using Bits = std::vector<std::uint32_t>;

  static void Set(Bits& bits, int index) { bits[index >> 5] |= 1U << (index & 31); }

  VoxelIndex lo_;
  VoxelIndex hi_;
  int row_lo_x_ = 0;    // of the first whole byte
  int row_voxels_ = 0;  // a multiple of 8
  int rows_ = 0;        // along y
  int layers_ = 0;
  Bits passed_;
  Bits hits_;
};

template <typename Fresh>
int ScanWindow::SetHits(const std::int32_t* index, int n, Fresh fresh) {
  std::uint32_t* const bits = hits_.data();
  int inside = 0;
  for (int i = 0; i < n; ++i) {
    const int at = index[i];
    inside += at >= 0 ? 1 : 0;
    if (at >= 0 && ((bits[at >> 5] >> (at & 31)) & 1U) == 0) {
      bits[at >> 5] |= 1U << (at & 31);
      fresh(i);
    }
  }
  return inside;
}

template <typename Visit>
void ScanWindow::TakeRows(Visit visit) {
  const int bytes_a_row = row_voxels_ / 8;
  const int words = (bytes_a_row * rows_ * layers_ + 3) / 4;
  for (int word = 0; word < words; ++word) {
    if ((passed_[word] | hits_[word]) == 0) {
      continue;
    }
    for (int b = 0; b < 4; ++b) {
      const std::uint32_t hits = (hits_[word] >> (8 * b)) & 255U;
      const std::uint32_t passed = (passed_[word] >> (8 * b)) & 255U;
      if ((hits | passed) != 0) {
        const int byte = 4 * word + b;
        const int row = byte / bytes_a_row;
        const int layer = row / rows_;
        visit(VoxelIndex{row_lo_x_ + 8 * (byte - row * bytes_a_row), lo_.y + row - layer * rows_,
                         lo_.z + layer},
              hits, passed);
      }
    }
    passed_[word] = hits_[word] = 0;
  }
}

}  // namespace pipewright
