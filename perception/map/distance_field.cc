// SPDX-License-Identifier: MIT
#include "perception/map/distance_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "perception/map/distance_cell.h"

namespace pipewright {
namespace {

using namespace distance_cell;  // NOLINT(google-build-using-namespace): this file's own words

// Along x: `cells` holds kHere at obstacles and kNone elsewhere.
void SweepRow(int n, int range, Packed* cells) {
  int last = -2 * range;
  for (int x = 0; x < n; ++x) {
    last = cells[x] == kHere ? x : last;
    cells[x] = x - last <= range ? kHere + Shifted(last - x, 0) : kNone;
  }
  last = n + 2 * range;
  for (int x = n - 1; x >= 0; --x) {
    last = cells[x] == kHere ? x : last;
    const Packed right = last - x <= range ? kHere + Shifted(last - x, 0) : kNone;
    cells[x] = std::min(cells[x], right);
  }
}

void TakeNearer(const Packed* from, Packed shift, int n, Packed* best) {
  for (int x = 0; x < n; ++x) {
    const Packed there = from[x] + shift;
    best[x] = there < best[x] ? there : best[x];
  }
}

// Along y or z: row `at` of `rows` rows that lie `stride` cells apart. Stops as soon as no row that
// is still farther off can be nearer to any cell of this one: exact, and short amid obstacles.
void MergeRows(const Packed* from, int at, int rows, int stride, int axis, int n, int range,
               Packed* best) {
  std::copy(from, from + n, best);
  for (int off = 1; off <= range; ++off) {
    if (*std::max_element(best, best + n) <= (off * off << kDistanceShift)) {
      return;
    }
    if (at - off >= 0) {
      TakeNearer(from - off * stride, Shifted(-off, axis), n, best);
    }
    if (at + off < rows) {
      TakeNearer(from + off * stride, Shifted(off, axis), n, best);
    }
  }
}

}  // namespace

DistanceField::DistanceField() = default;
DistanceField::DistanceField(const DistanceField&) = default;
DistanceField& DistanceField::operator=(const DistanceField&) = default;
DistanceField::~DistanceField() = default;

DistanceField::DistanceField(const MapConfig& config)
    : config_(config),
      nx_(VoxelsAlong(config.lo.x, config.hi.x)),
      ny_(VoxelsAlong(config.lo.y, config.hi.y)),
      nz_(VoxelsAlong(config.lo.z, config.hi.z)),
      range_(static_cast<int>(std::ceil(config.field_range_m / config.width_m - 1e-9)) + 1) {
  assert(Valid(config));
  const std::size_t columns = static_cast<std::size_t>(nx_) * ny_;
  const std::size_t cells = columns * nz_;
  cells_.assign(cells, kHere);  // all is unknown, so all is an obstacle
  scratch_.resize(cells);
  unknown_.assign(cells / 64 + 1, ~std::uint64_t{0});
  columns_.assign(columns, kHere);
  column_unknown_.assign(columns, 1);
}

void DistanceField::Update(const VoxelGrid& grid) {
  assert(grid.voxel_count() == nx_ * ny_ * nz_);
  if (grid.revision() == revision_) {
    return;
  }
  revision_ = grid.revision();
  ReadObstacles(grid);
  const int layer = nx_ * ny_;
  for (int row = 0; row < ny_ * nz_; ++row) {
    SweepRow(nx_, range_, &cells_[row * nx_]);
  }
  for (int row = 0; row < ny_ * nz_; ++row) {
    MergeRows(&cells_[row * nx_], row % ny_, ny_, nx_, 1, nx_, range_, &scratch_[row * nx_]);
  }
  for (int row = 0; row < ny_ * nz_; ++row) {
    MergeRows(&scratch_[row * nx_], row / ny_, nz_, layer, 2, nx_, range_, &cells_[row * nx_]);
  }
  for (int y = 0; y < ny_; ++y) {
    SweepRow(nx_, range_, &columns_[y * nx_]);
  }
  std::copy(columns_.begin(), columns_.end(), scratch_.begin());
  for (int y = 0; y < ny_; ++y) {
    MergeRows(&scratch_[y * nx_], y, ny_, nx_, 1, nx_, range_, &columns_[y * nx_]);
  }
}

void DistanceField::ReadObstacles(const VoxelGrid& grid) {
  std::fill(unknown_.begin(), unknown_.end(), 0);
  std::fill(columns_.begin(), columns_.end(), kNone);
  std::fill(column_unknown_.begin(), column_unknown_.end(), std::uint8_t{1});
  int index = 0;
  for (int z = 0; z < nz_; ++z) {
    const double center_m = (config_.lo.z + z + 0.5) * config_.width_m;
    const bool in_way = config_.column_lo_m <= center_m && center_m <= config_.column_hi_m;
    for (int column = 0; column < nx_ * ny_; ++column, ++index) {
      const bool obstacle = grid.ObstacleAt(index);
      cells_[index] = obstacle ? kHere : kNone;
      const bool known = obstacle && grid.KnownAt(index);
      unknown_[index >> 6] |= static_cast<std::uint64_t>(obstacle && !known) << (index & 63);
      if (in_way && obstacle) {
        columns_[column] = kHere;
        column_unknown_[column] &= known ? 0 : 1;
      }
    }
  }
}

std::int64_t DistanceField::MemoryBytes() const {
  const auto bytes = [](const auto& v) {
    return static_cast<std::int64_t>(v.capacity() * sizeof(v[0]));
  };
  return bytes(cells_) + bytes(columns_) + bytes(scratch_) + bytes(unknown_) +
         bytes(column_unknown_);
}

}  // namespace pipewright
