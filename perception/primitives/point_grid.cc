// SPDX-License-Identifier: MIT
#include "perception/primitives/point_grid.h"

#include <cassert>

namespace pipewright {

void PointGrid::Set(std::span<const Eigen::Vector3f> points, float width_m) {
  assert(points.size() <= kMaxPoints && width_m > 0);
  points_ = points;
  width_m_ = width_m;
  first_.fill(0);
  for (const Eigen::Vector3f& p : points) {
    ++first_[SlotOf(CellOf(p)) + 1];
  }
  for (int slot = 0; slot < kSlots; ++slot) {
    first_[slot + 1] += first_[slot];
  }
  // Filling from each slot's end backwards leaves first_ at the begins.
  for (int i = static_cast<int>(points.size()) - 1; i >= 0; --i) {
    const int slot = SlotOf(CellOf(points[i]));
    order_[--first_[slot + 1]] = i;
  }
  for (int slot = 0; slot < kSlots; ++slot) {
    first_[slot] = first_[slot + 1];
  }
  first_[kSlots] = static_cast<int>(points.size());
}

}  // namespace pipewright
