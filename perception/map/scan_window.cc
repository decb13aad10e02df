// SPDX-License-Identifier: MIT
#include "perception/map/scan_window.h"

#include <algorithm>

namespace pipewright {
namespace {

// Whole bytes that hold the voxels lo to hi.
int RowVoxels(int lo, int hi) { return ((hi >> 3) - (lo >> 3) + 1) * 8; }

}  // namespace

ScanWindow::ScanWindow(const MapConfig& box) {
  const std::size_t row = static_cast<std::size_t>(RowVoxels(box.lo.x, box.hi.x));
  const std::size_t rows = static_cast<std::size_t>(VoxelsAlong(box.lo.y, box.hi.y)) *
                           static_cast<std::size_t>(VoxelsAlong(box.lo.z, box.hi.z));
  passed_.resize(row * rows / 32 + 1);
  hits_.resize(row * rows / 32 + 1);
}

void ScanWindow::Open(const VoxelIndex& lo, const VoxelIndex& hi) {
  lo_ = lo;
  hi_ = hi;
  const bool any = Within(lo, lo, hi);
  row_lo_x_ = lo.x & ~7;
  row_voxels_ = any ? RowVoxels(lo.x, hi.x) : 8;
  rows_ = any ? VoxelsAlong(lo.y, hi.y) : 0;
  layers_ = any ? VoxelsAlong(lo.z, hi.z) : 0;
}

void ScanWindow::ClearHits() {
  const auto words = static_cast<std::ptrdiff_t>(stride_z()) * layers_ / 32 + 1;
  std::fill(hits_.begin(), hits_.begin() + words, 0U);
}

std::int64_t ScanWindow::MemoryBytes() const {
  return static_cast<std::int64_t>((passed_.capacity() + hits_.capacity()) * sizeof(passed_[0]));
}

}  // namespace pipewright
