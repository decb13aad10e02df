// SPDX-License-Identifier: MIT
#include "perception/map/distance_field.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pipewright {

using distance_cell::kHere;

DistanceField::DistanceField() = default;
DistanceField::~DistanceField() = default;

DistanceField::DistanceField(const MapConfig& config)
    : config_(config),
      nx_(VoxelsAlong(config.lo.x, config.hi.x)),
      ny_(VoxelsAlong(config.lo.y, config.hi.y)),
      nz_(VoxelsAlong(config.lo.z, config.hi.z)),
      range_(static_cast<int>(std::ceil(config.field_range_m / config.width_m - 1e-9)) + 1),
      transform_(nx_, ny_, nz_, range_),
      column_transform_(nx_, ny_, 1, range_) {
  assert(Valid(config));
  const std::size_t columns = static_cast<std::size_t>(nx_) * ny_;
  const std::size_t cells = columns * nz_;
  cells_.assign(cells, kHere);  // all is unknown, so all is an obstacle
  unknown_.assign(cells / 64 + 1, ~std::uint64_t{0});
  columns_.assign(columns, kHere);
  column_unknown_.assign(columns, 1);
  seen_.assign(static_cast<std::size_t>(BricksOfBox(config)), 0);
  dirty_rows_.assign(static_cast<std::size_t>(ny_) * nz_, 0);
  dirty_column_rows_.assign(static_cast<std::size_t>(ny_), 0);
}

DistanceField::DistanceField(const DistanceField& other) { *this = other; }

DistanceField& DistanceField::operator=(const DistanceField& other) {
  if (this == &other) {
    return *this;
  }
  config_ = other.config_;
  nx_ = other.nx_;
  ny_ = other.ny_;
  nz_ = other.nz_;
  range_ = other.range_;
  revision_ = other.revision_;
  cells_ = other.cells_;
  columns_ = other.columns_;
  unknown_ = other.unknown_;
  column_unknown_ = other.column_unknown_;
  fresh_ = false;
  if (!transform_.SameShape(other.transform_)) {
    transform_ = other.transform_;
    column_transform_ = other.column_transform_;
  }
  seen_.resize(other.seen_.size());
  dirty_rows_.resize(other.dirty_rows_.size());
  dirty_column_rows_.resize(other.dirty_column_rows_.size());
  return *this;
}

void DistanceField::Update(const VoxelGrid& grid) {
  assert(grid.voxel_count() == nx_ * ny_ * nz_);
  if (grid.revision() == revision_) {
    return;
  }
  revision_ = grid.revision();
  if (grid.config().lo != config_.lo) {  // its window moved, and all cells with it
    config_ = grid.config();
    fresh_ = false;
  }
  FindChanges(grid);
  const auto read_row = [&](int y, int z, std::uint8_t* obstacle) {
    const int row = nx_ * (y + ny_ * z);
    for (int x = 0; x < nx_; ++x) {
      obstacle[x] = grid.ObstacleAt(row + x) ? 1 : 0;
    }
  };
  const auto read_columns = [&](int y, int, std::uint8_t* obstacle) {
    ReadColumns(grid, y, obstacle);
  };
  transform_.Update(!fresh_, dirty_rows_.data(), read_row, cells_.data());
  column_transform_.Update(!fresh_, dirty_column_rows_.data(), read_columns, columns_.data());
  fresh_ = true;
}

bool DistanceField::InWay(int z) const {
  const double center_m = (config_.lo.z + z + 0.5) * config_.width_m;
  return config_.column_lo_m <= center_m && center_m <= config_.column_hi_m;
}

void DistanceField::FindChanges(const VoxelGrid& grid) {
  for (int block = 0; block < grid.block_count(); ++block) {
    if (!fresh_ || seen_[block] != grid.BlockRevision(block)) {
      seen_[block] = grid.BlockRevision(block);
      ReadBlock(grid, grid.BlockBox(block));
    }
  }
}

void DistanceField::ReadBlock(const VoxelGrid& grid, const VoxelBox& block) {
  for (int z = block.lo.z; z <= block.hi.z; ++z) {
    for (int y = block.lo.y; y <= block.hi.y; ++y) {
      bool moved = false;
      bool told = false;
      int index = grid.IndexOf({block.lo.x, y, z});
      for (int x = block.lo.x; x <= block.hi.x; ++x, ++index) {
        const bool obstacle = grid.ObstacleAt(index);
        const bool unknown = obstacle && !grid.KnownAt(index);
        moved = moved || obstacle != transform_.ObstacleAt(index);
        told = told || unknown != UnknownAt(index);
        const std::uint64_t bit = std::uint64_t{1} << (index & 63);
        std::uint64_t& word = unknown_[index >> 6];
        word = unknown ? word | bit : word & ~bit;
      }
      const int row = y - config_.lo.y;
      const int layer = z - config_.lo.z;
      if (moved) {
        dirty_rows_[row + ny_ * layer] = 1;
      }
      if ((moved || told) && InWay(layer)) {
        dirty_column_rows_[row] = 1;
      }
    }
  }
}

// A column is unknown if all its obstacles are.
void DistanceField::ReadColumns(const VoxelGrid& grid, int y, std::uint8_t* obstacle) {
  std::uint8_t* const unknown = &column_unknown_[nx_ * y];
  std::fill(obstacle, obstacle + nx_, std::uint8_t{0});
  std::fill(unknown, unknown + nx_, std::uint8_t{1});
  for (int z = 0; z < nz_; ++z) {
    const int row = nx_ * (y + ny_ * z);
    for (int x = 0; InWay(z) && x < nx_; ++x) {
      if (grid.ObstacleAt(row + x)) {
        obstacle[x] = 1;
        unknown[x] = static_cast<std::uint8_t>(grid.KnownAt(row + x) ? 0 : unknown[x]);
      }
    }
  }
}

std::int64_t DistanceField::MemoryBytes() const {
  const auto bytes = [](const auto& v) {
    return static_cast<std::int64_t>(v.capacity() * sizeof(v[0]));
  };
  return bytes(cells_) + bytes(columns_) + bytes(unknown_) + bytes(column_unknown_) +
         transform_.MemoryBytes() + column_transform_.MemoryBytes() + bytes(seen_) +
         bytes(dirty_rows_) + bytes(dirty_column_rows_);
}

bool operator==(const DistanceField& a, const DistanceField& b) {
  return a.cells_ == b.cells_ && a.columns_ == b.columns_ && a.unknown_ == b.unknown_ &&
         a.column_unknown_ == b.column_unknown_;
}

}  // namespace pipewright
