// SPDX-License-Identifier: MIT
#include "hil/cli/map_window.h"

#include <cassert>
#include <cmath>

namespace pipewright::hil {

void MapWindow::Follow(const Vector3d& p_W) {
  const VoxelIndex by = grid_.BricksTo(p_W);
  if (by == VoxelIndex{}) {
    return;
  }
  ++moves_;
  grid_.Move(by, [this](const BrickVoxels& brick) {
    left_[{brick.lo.z, brick.lo.y, brick.lo.x}] = brick;
  });
  TakeIn();
}

void MapWindow::TakeIn() {
  for (auto it = left_.begin(); it != left_.end();) {
    const BrickVoxels& brick = it->second;
    if (!grid_.InBox(brick.lo)) {
      ++it;
      continue;
    }
    for (int i = 0; i < BrickVoxels::kVoxels; ++i) {
      if (brick.known[i]) {
        const bool taken = grid_.Restore(brick.VoxelAt(i), brick.log_odds[i]);
        assert(taken);  // there is a brick for each
        (void)taken;
      }
    }
    it = left_.erase(it);
  }
}

std::int64_t MapWindow::known_outside() const {
  std::int64_t known = 0;
  for (const auto& [key, brick] : left_) {
    known += static_cast<std::int64_t>(brick.known.count());
  }
  return known;
}

VoxelBox WindowBox(double side_m, double width_m) {
  constexpr int kSide = BrickVoxels::kSide;
  const int side = kSide * static_cast<int>(std::ceil(side_m / (kSide * width_m)));
  return {{0, 0, 0}, {side - 1, side - 1, side - 1}};
}

}  // namespace pipewright::hil
