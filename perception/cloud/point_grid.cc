// SPDX-License-Identifier: MIT
#include "perception/cloud/point_grid.h"

#include <cassert>

namespace pipewright {

void PointGrid::Set(std::span<const Eigen::Vector3f> points, float width_m) {
  assert(points.size() <= kMaxPoints && width_m > 0);
  points_ = points;
  width_m_ = width_m;
  end_.fill(0);
  for (const Eigen::Vector3f& p : points) {
    ++end_[SlotOf(CellOf(p))];
  }
  int begin = 0;
  for (int slot = 0; slot < kSlots; ++slot) {
    first_[slot] = begin;
    begin += end_[slot];
    end_[slot] = first_[slot];
  }
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    order_[end_[SlotOf(CellOf(points[i]))]++] = i;
  }
}

}  // namespace pipewright
