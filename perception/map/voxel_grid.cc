// SPDX-License-Identifier: MIT
#include "perception/map/voxel_grid.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <type_traits>

namespace pipewright {
namespace {

StoredLogOdds Stored(float log_odds) {
  if constexpr (std::is_integral_v<StoredLogOdds>) {
    return static_cast<StoredLogOdds>(std::lround(log_odds / kLogOddsUnit));
  } else {
    return static_cast<StoredLogOdds>(log_odds);
  }
}

StoredLogOdds LogOddsOf(double probability) {
  return Stored(static_cast<float>(std::log(probability / (1 - probability))));
}

int CellOf(double coordinate, double width_inv) {
  constexpr double kFar = 1 << 24;  // beyond every box; also what NaN becomes
  const double cell = std::floor(coordinate * width_inv);
  return static_cast<int>(cell > -kFar ? std::min(cell, kFar) : -kFar);
}

constexpr float kSolidHits = 1.5F;  // more than one hit above what misses took away

}  // namespace

VoxelBox BoxOf(const Vector3d& lo_W, const Vector3d& hi_W, double width_m, int margin) {
  constexpr double kSlack = 1e-9;  // a border that means to lie on a voxel's stays there
  const Vector3d lo = (lo_W / width_m).array() + kSlack;
  const Vector3d hi = (hi_W / width_m).array() - kSlack;
  return {{CellOf(lo.x(), 1) - margin, CellOf(lo.y(), 1) - margin, CellOf(lo.z(), 1) - margin},
          {CellOf(hi.x(), 1) + margin, CellOf(hi.y(), 1) + margin, CellOf(hi.z(), 1) + margin}};
}

VoxelGrid::VoxelGrid(const MapConfig& config)
    : config_(config),
      nx_(VoxelsAlong(config.lo.x, config.hi.x)),
      ny_(VoxelsAlong(config.lo.y, config.hi.y)),
      nz_(VoxelsAlong(config.lo.z, config.hi.z)),
      hit_(LogOddsOf(config.p_hit)),
      miss_(LogOddsOf(config.p_miss)),
      min_(LogOddsOf(config.p_min)),
      max_(LogOddsOf(config.p_max)),
      threshold_(LogOddsOf(config.p_occupied)),
      solid_from_(static_cast<StoredLogOdds>(kSolidHits * static_cast<float>(hit_))),
      bricks_x_((config.hi.x >> 3) - (config.lo.x >> 3) + 1),
      bricks_y_((config.hi.y >> 3) - (config.lo.y >> 3) + 1),
      window_(config) {
  assert(Valid(config));
  const auto voxels = static_cast<std::size_t>(voxel_count());
  top_.assign(static_cast<std::size_t>(BricksOfBox(config)), -1);
  block_revisions_.resize(top_.size());
  probed_near_.resize(top_.size());
  bricks_.resize(static_cast<std::size_t>(std::min(config.brick_capacity, BricksOfBox(config))));
  free_bricks_.resize(bricks_.size());
  std::iota(free_bricks_.rbegin(), free_bricks_.rend(), 0);
  bricks_free_ = static_cast<int>(bricks_.size());
  codes_.resize(voxels / 16 + 2);  // a row's bits are read four bytes at a time
  flags_.resize(voxels / 64 + 1);
  solid_.resize(voxels / 64 + 1);
  ends_.resize(std::min(voxels, static_cast<std::size_t>(kDiscretizedEnds)));
  TabulateEntropy();
  const VoxelIndex& lo = config.workspace_lo;
  const VoxelIndex& hi = config.workspace_hi;
  counts_.total = VoxelsAlong(lo.x, hi.x) * VoxelsAlong(lo.y, hi.y) * VoxelsAlong(lo.z, hi.z);
  counts_.unknown = counts_.total;
}

VoxelState VoxelGrid::State(const VoxelIndex& v) const {
  const unsigned code = InBox(v) ? Code(IndexOf(v)) : 0;
  if ((code & kKnown) == 0) {
    return VoxelState::kUnknown;
  }
  return code == kOccupiedCode ? VoxelState::kOccupied : VoxelState::kFree;
}

float VoxelGrid::LogOdds(const VoxelIndex& v) const {
  const int brick = InBox(v) ? top_[BrickOf(v)] : -1;
  return brick < 0 ? 0 : static_cast<float>(bricks_[brick].log_odds[CellInBrick(v)]) * kLogOddsUnit;
}

bool VoxelGrid::Covered(const VoxelIndex& v) const { return InBox(v) && CoveredAt(IndexOf(v)); }

bool VoxelGrid::Swept(const VoxelIndex& v) const {
  return InBox(v) && Code(IndexOf(v)) == kSweptCode;
}

bool VoxelGrid::Residual(const VoxelIndex& v) const {
  return InBox(v) && !KnownAt(IndexOf(v)) && Flag(IndexOf(v));
}

bool VoxelGrid::Obstacle(const VoxelIndex& v) const {
  return InBox(v) ? ObstacleAt(IndexOf(v)) : config_.outside_is_obstacle;
}

VoxelIndex VoxelGrid::VoxelOf(const Vector3d& p_W) const {
  const double inv = 1 / config_.width_m;
  return {CellOf(p_W.x(), inv), CellOf(p_W.y(), inv), CellOf(p_W.z(), inv)};
}

Vector3d VoxelGrid::Center(const VoxelIndex& v) const {
  return {(v.x + 0.5) * config_.width_m, (v.y + 0.5) * config_.width_m,
          (v.z + 0.5) * config_.width_m};
}

VoxelIndex VoxelGrid::VoxelAt(int index) const {
  const int row = index / nx_;
  const int layer = row / ny_;
  return {config_.lo.x + index - row * nx_, config_.lo.y + row - layer * ny_, config_.lo.z + layer};
}

int VoxelGrid::BrickOf(const VoxelIndex& v) const {
  return ((v.x >> 3) - (config_.lo.x >> 3)) +
         bricks_x_ *
             (((v.y >> 3) - (config_.lo.y >> 3)) + bricks_y_ * ((v.z >> 3) - (config_.lo.z >> 3)));
}

VoxelBox VoxelGrid::BlockBox(int block) const {
  const int row = block / bricks_x_;
  const int layer = row / bricks_y_;
  const VoxelIndex lo{((config_.lo.x >> 3) + block - row * bricks_x_) * 8,
                      ((config_.lo.y >> 3) + row - layer * bricks_y_) * 8,
                      ((config_.lo.z >> 3) + layer) * 8};
  return {
      {std::max(lo.x, config_.lo.x), std::max(lo.y, config_.lo.y), std::max(lo.z, config_.lo.z)},
      {std::min(lo.x + 7, config_.hi.x), std::min(lo.y + 7, config_.hi.y),
       std::min(lo.z + 7, config_.hi.z)}};
}

StoredLogOdds* VoxelGrid::LogOddsSlot(const VoxelIndex& v) {
  std::int32_t& brick = top_[BrickOf(v)];
  if (brick < 0) {
    if (bricks_free_ == 0) {
      return nullptr;
    }
    brick = free_bricks_[--bricks_free_];
  }
  return &bricks_[brick].log_odds[CellInBrick(v)];
}

bool VoxelGrid::Restore(const VoxelIndex& v, float log_odds) {
  if (!InBox(v) || !std::isfinite(log_odds)) {
    return false;
  }
  StoredLogOdds* slot = LogOddsSlot(v);
  if (slot == nullptr) {
    ++updates_refused_;
    return false;
  }
  constexpr float kBeyond = 7;  // any clamp, and what an int16 holds
  *slot = std::clamp(Stored(std::clamp(log_odds, -kBeyond, kBeyond)), min_, max_);
  Become(IndexOf(v), v, *slot >= threshold_);
  MarkSolid(IndexOf(v), *slot);
  return true;
}

// Known from now on, and occupied or free.
void VoxelGrid::Become(int index, const VoxelIndex& v, bool occupied) {
  const unsigned from = Code(index);
  const unsigned to = occupied ? kOccupiedCode : kKnown;
  if (from == to) {
    return;
  }
  if (InWorkspace(v)) {
    CountChange(from, to, Flag(index));
  }
  SetCode(index, to);
  if ((from & kKnown) == 0) {
    SetFlag(index, false);  // it was "residual"
  }
  const int block = BrickOf(v);
  Touch(block);
  if (!occupied && probed_near_[block] != 0) {
    ForgetProbedInTheOpen(v);
  }
}

void VoxelGrid::CountChange(unsigned from, unsigned to, bool flag) {
  if ((from & kKnown) == 0) {
    --(flag ? counts_.residual : counts_.unknown);
  } else if (from == kOccupiedCode) {
    --counts_.occupied;
    counts_.covered -= flag ? 1 : 0;
  } else {
    --counts_.free;
  }
  ++(to == kOccupiedCode ? counts_.occupied : counts_.free);
  counts_.covered += to == kOccupiedCode && (from & kKnown) != 0 && flag ? 1 : 0;
}

std::int64_t VoxelGrid::MemoryBytes() const {
  const auto bytes = [](const auto& v) {
    return static_cast<std::int64_t>(v.capacity() * sizeof(v[0]));
  };
  return bytes(top_) + bytes(block_revisions_) + bytes(probed_near_) + bytes(bricks_) +
         bytes(free_bricks_) + bytes(codes_) + bytes(flags_) + bytes(solid_) +
         window_.MemoryBytes() + bytes(ends_) + bytes(entropy_table_);
}

}  // namespace pipewright
