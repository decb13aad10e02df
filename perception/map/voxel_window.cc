// SPDX-License-Identifier: MIT
// The box as a window that moves over the world, brick by brick.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

#include "perception/map/voxel_grid.h"

namespace pipewright {
namespace {

constexpr int kSide = BrickVoxels::kSide;

/// Rows of a box, and how many of which it moves: row (y, z) becomes what (y + by_y, z + by_z) was.
struct RowMove {
  int row_bytes;
  int rows;
  int layers;
  int by_bytes;
  int by_rows;
  int by_layers;
};

// In place: each row is read before anything is written to it.
void MoveRows(const RowMove& m, int entering, void* data) {
  auto* const bytes = static_cast<unsigned char*>(data);
  const int n = m.rows * m.layers;
  const bool upwards = m.by_layers * m.rows + m.by_rows >= 0;
  const int shift = std::min(std::abs(m.by_bytes), m.row_bytes);
  const auto kept = static_cast<std::size_t>(m.row_bytes - shift);
  for (int i = 0; i < n; ++i) {
    const int row = upwards ? i : n - 1 - i;
    const int from_y = row % m.rows + m.by_rows;
    const int from_z = row / m.rows + m.by_layers;
    unsigned char* const to = bytes + static_cast<std::ptrdiff_t>(row) * m.row_bytes;
    if (from_y < 0 || from_y >= m.rows || from_z < 0 || from_z >= m.layers) {
      std::memset(to, entering, static_cast<std::size_t>(m.row_bytes));
      continue;
    }
    const unsigned char* const from =
        bytes + static_cast<std::ptrdiff_t>(from_y + m.rows * from_z) * m.row_bytes;
    const bool forwards = m.by_bytes >= 0;
    std::memmove(to + (forwards ? 0 : shift), from + (forwards ? shift : 0), kept);
    std::memset(to + (forwards ? static_cast<int>(kept) : 0), entering,
                static_cast<std::size_t>(shift));
  }
}

void Add(const VoxelIndex& by, VoxelIndex* v) { *v = {v->x + by.x, v->y + by.y, v->z + by.z}; }

// How far from lo to move so that [lo, hi] has p in the middle, in bricks, and stays in the keys.
int BricksAlong(double p, int lo, int hi) {
  constexpr int kReach = (1 << 15) / kSide;
  const double middle = 0.5 * (lo + hi + 1);
  const double bricks = std::round((p - middle) / kSide);
  const int least = -kReach - lo / kSide;
  const int most = kReach - (hi + 1) / kSide;
  return static_cast<int>(std::clamp<double>(bricks, least, most));
}

}  // namespace

VoxelIndex VoxelGrid::BricksTo(const Vector3d& p_W) const {
  if (!p_W.allFinite()) {
    return {};
  }
  const Vector3d p = p_W / config_.width_m;
  const VoxelIndex& lo = config_.lo;
  const VoxelIndex& hi = config_.hi;
  return {BricksAlong(p.x(), lo.x, hi.x), BricksAlong(p.y(), lo.y, hi.y),
          BricksAlong(p.z(), lo.z, hi.z)};
}

BrickVoxels VoxelGrid::VoxelsOf(int block) const {
  BrickVoxels voxels;
  voxels.lo = BlockBox(block).lo;
  const Brick& brick = bricks_[top_[block]];
  for (int i = 0; i < kBrickVoxels; ++i) {
    const int index = IndexOf(voxels.VoxelAt(i));
    voxels.log_odds[i] = static_cast<float>(brick.log_odds[i]) * kLogOddsUnit;
    voxels.known[i] = KnownAt(index);
    voxels.probed[i] = KnownAt(index) && Flag(index);
  }
  return voxels;
}

void VoxelGrid::Release(int block) {
  const std::int32_t brick = std::exchange(top_[block], -1);
  bricks_[brick] = {};
  free_bricks_[bricks_free_++] = brick;
}

void VoxelGrid::Shift(const VoxelIndex& bricks) {
  const VoxelIndex by{kSide * bricks.x, kSide * bricks.y, kSide * bricks.z};
  MoveRows({nx_ / 4, ny_, nz_, by.x / 4, by.y, by.z}, 0, codes_.data());
  MoveRows({nx_ / 8, ny_, nz_, by.x / 8, by.y, by.z}, 0, flags_.data());
  MoveRows({nx_ / 8, ny_, nz_, by.x / 8, by.y, by.z}, 0, solid_.data());
  constexpr int kBytes = sizeof(top_[0]);
  MoveRows({bricks_x_ * kBytes, bricks_y_, nz_ / kSide, bricks.x * kBytes, bricks.y, bricks.z},
           0xFF, top_.data());  // -1: no brick
  MoveRows({bricks_x_, bricks_y_, nz_ / kSide, bricks.x, bricks.y, bricks.z}, 1,
           probed_near_.data());  // what enters may lie beside what stays
  for (VoxelIndex* corner :
       {&config_.lo, &config_.hi, &config_.workspace_lo, &config_.workspace_hi}) {
    Add(by, corner);
  }
  ++revision_;
  std::fill(block_revisions_.begin(), block_revisions_.end(), revision_);
  Recount();
}

void VoxelGrid::Recount() {
  const VoxelIndex& lo = config_.workspace_lo;
  const VoxelIndex& hi = config_.workspace_hi;
  counts_ = {.total = counts_.total};
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      int index = IndexOf({lo.x, y, z});
      for (int x = lo.x; x <= hi.x; ++x, ++index) {
        const bool occupied = OccupiedAt(index);
        const bool known = KnownAt(index);
        counts_.occupied += occupied ? 1 : 0;
        counts_.free += known && !occupied ? 1 : 0;
        counts_.residual += !known && Flag(index) ? 1 : 0;
        counts_.unknown += !known && !Flag(index) ? 1 : 0;
        counts_.covered += CoveredAt(index) ? 1 : 0;
      }
    }
  }
}

}  // namespace pipewright
