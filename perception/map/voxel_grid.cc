// SPDX-License-Identifier: MIT
#include "perception/map/voxel_grid.h"

#include <algorithm>
#include <cassert>
#include <type_traits>

#include "perception/map/ray_walk.h"

namespace pipewright {
namespace {

constexpr double kEntropyUnit = 1.0 / (std::int64_t{1} << 40);  // nats; sums of these are exact
constexpr int kEntropyIntervals = 4096;
constexpr double kLn2 = 0.69314718055994530942;

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

double EntropyOf(double log_odds) {
  const double p = 1 - 1 / (1 + std::exp(log_odds));
  return -p * std::log(p) - (1 - p) * std::log(1 - p);
}

int CellOf(double coordinate, double width_inv) {
  constexpr double kFar = 1 << 24;  // beyond every box; also what NaN becomes
  const double cell = std::floor(coordinate * width_inv);
  return static_cast<int>(cell > -kFar ? std::min(cell, kFar) : -kFar);
}

double SquaredDistanceToBox(const Vector3d& p, const Vector3d& center, double half_width) {
  return ((p - center).cwiseAbs().array() - half_width).max(0.0).matrix().squaredNorm();
}

constexpr unsigned kSweptCode = 1;
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
  bricks_.resize(static_cast<std::size_t>(std::min(config.brick_capacity, BricksOfBox(config))));
  codes_.resize(voxels / 16 + 2);  // a row's bits are read four bytes at a time
  flags_.resize(voxels / 64 + 1);
  solid_.resize(voxels / 64 + 1);
  ends_.resize(std::min(voxels, static_cast<std::size_t>(kDiscretizedEnds)));
  entropy_table_.resize(kEntropyIntervals + 2);
  for (int i = 0; i < kEntropyIntervals + 2; ++i) {
    const double log_odds = min_ + (static_cast<double>(max_) - min_) * i / kEntropyIntervals;
    entropy_table_[i] = std::llround(EntropyOf(log_odds * kLogOddsUnit) / kEntropyUnit);
  }
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

StoredLogOdds* VoxelGrid::LogOddsSlot(const VoxelIndex& v) {
  std::int32_t& brick = top_[BrickOf(v)];
  if (brick < 0) {
    if (bricks_used_ == static_cast<int>(bricks_.size())) {
      return nullptr;
    }
    brick = bricks_used_++;
  }
  return &bricks_[brick].log_odds[CellInBrick(v)];
}

std::int64_t VoxelGrid::EntropyUnits(StoredLogOdds log_odds) const {
  const double u = (static_cast<double>(log_odds) - min_) / (static_cast<double>(max_) - min_) *
                   kEntropyIntervals;
  const int i = static_cast<int>(u);
  const auto step = static_cast<double>(entropy_table_[i + 1] - entropy_table_[i]);
  return entropy_table_[i] + static_cast<std::int64_t>(step * (u - i));
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
  ++revision_;
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

void VoxelGrid::MarkSweptSphere(const Vector3d& center_W, double radius_m) {
  const Vector3d reach = Vector3d::Constant(radius_m);
  const VoxelIndex lo = VoxelOf(center_W - reach);
  const VoxelIndex hi = VoxelOf(center_W + reach);
  for (int z = std::max(lo.z, config_.lo.z); z <= std::min(hi.z, config_.hi.z); ++z) {
    for (int y = std::max(lo.y, config_.lo.y); y <= std::min(hi.y, config_.hi.y); ++y) {
      for (int x = std::max(lo.x, config_.lo.x); x <= std::min(hi.x, config_.hi.x); ++x) {
        const int index = IndexOf({x, y, z});
        if (Code(index) == 0 && SquaredDistanceToBox(center_W, Center({x, y, z}),
                                                     config_.width_m / 2) <= radius_m * radius_m) {
          SetCode(index, kSweptCode);
          ++revision_;
        }
      }
    }
  }
}

int VoxelGrid::MarkCovered(const Vector3d& p_WP, double radius_m) {
  const Vector3d reach = Vector3d::Constant(radius_m);
  const VoxelIndex lo = VoxelOf(p_WP - reach);
  const VoxelIndex hi = VoxelOf(p_WP + reach);
  const VoxelIndex& w_lo = config_.workspace_lo;
  const VoxelIndex& w_hi = config_.workspace_hi;
  int covered = 0;
  for (int z = std::max(lo.z, w_lo.z); z <= std::min(hi.z, w_hi.z); ++z) {
    for (int y = std::max(lo.y, w_lo.y); y <= std::min(hi.y, w_hi.y); ++y) {
      for (int x = std::max(lo.x, w_lo.x); x <= std::min(hi.x, w_hi.x); ++x) {
        const int index = IndexOf({x, y, z});
        if (KnownAt(index) && !Flag(index) && Sees(p_WP, radius_m, {x, y, z})) {
          SetFlag(index, true);
          covered += OccupiedAt(index) ? 1 : 0;
        }
      }
    }
  }
  counts_.covered += covered;
  return covered;
}

// Whether v's centre is within the radius of P, and its centre or the middle of a face that is
// turned to P can be seen from there.
bool VoxelGrid::Sees(const Vector3d& p_WP, double radius_m, const VoxelIndex& v) const {
  const Vector3d center = Center(v);
  const Vector3d way = p_WP - center;
  if (!(way.squaredNorm() <= radius_m * radius_m)) {
    return false;
  }
  if (Sees(p_WP, center, v)) {
    return true;
  }
  const double to_face_m = 0.499 * config_.width_m;  // just inside: the walk ends in v
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(way(axis)) > config_.width_m / 2) {
      Vector3d face = center;
      face(axis) += way(axis) > 0 ? to_face_m : -to_face_m;
      if (Sees(p_WP, face, v)) {
        return true;
      }
    }
  }
  return false;
}

// Whether nothing lies before v on the segment from P to the point Q in v: no occupied voxel, and
// for a free v, which could be anything behind what is not known, no unknown one either.
bool VoxelGrid::Sees(const Vector3d& p_WP, const Vector3d& p_WQ, const VoxelIndex& v) const {
  const bool through_unknown = OccupiedAt(IndexOf(v));
  for (RayWalk ray(*this, p_WP.cast<float>(), p_WQ.cast<float>()); ray.Next();) {
    if (!ray.inside()) {
      continue;
    }
    if (ray.voxel() == v) {
      return true;
    }
    if (OccupiedAt(ray.index()) || (!through_unknown && Code(ray.index()) == 0)) {
      return false;
    }
  }
  return true;
}

void VoxelGrid::SetResidual(const VoxelIndex& v, bool residual) {
  if (!InBox(v) || KnownAt(IndexOf(v)) || Flag(IndexOf(v)) == residual) {
    return;
  }
  SetFlag(IndexOf(v), residual);
  if (InWorkspace(v)) {
    counts_.residual += residual ? 1 : -1;
    counts_.unknown -= residual ? 1 : -1;
  }
}

double VoxelGrid::visual_entropy() const {
  const VoxelIndex& lo = config_.workspace_lo;
  const VoxelIndex& hi = config_.workspace_hi;
  std::int64_t units = 0;  // of the known voxels of W, in 2^-40 nats
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x;) {
        const int end = std::min(hi.x, x | 7) + 1;
        const int brick = top_[BrickOf({x, y, z})];
        for (int index = IndexOf({x, y, z}); brick >= 0 && x < end; ++x, ++index) {
          units +=
              KnownAt(index) ? EntropyUnits(bricks_[brick].log_odds[CellInBrick({x, y, z})]) : 0;
        }
        x = end;
      }
    }
  }
  const int not_known = counts_.unknown + counts_.residual;
  return (not_known * kLn2 + static_cast<double>(units) * kEntropyUnit) / counts_.total;
}

double VoxelGrid::coverage_entropy() const {
  return (counts_.occupied - counts_.covered) * kLn2 / counts_.total;
}

std::int64_t VoxelGrid::MemoryBytes() const {
  const auto bytes = [](const auto& v) {
    return static_cast<std::int64_t>(v.capacity() * sizeof(v[0]));
  };
  return bytes(top_) + bytes(bricks_) + bytes(codes_) + bytes(flags_) + bytes(solid_) +
         window_.MemoryBytes() + bytes(ends_) + bytes(entropy_table_);
}

}  // namespace pipewright
