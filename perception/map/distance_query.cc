// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/map/distance_cell.h"
#include "perception/map/distance_field.h"

namespace pipewright {
namespace {

using distance_cell::kNone;
using distance_cell::Offset;
using distance_cell::Packed;
using distance_cell::SquaredDistance;

// Keeps the nearest of the voxel boxes it is shown.
class NearestBox {
 public:
  NearestBox(const Vector3d& p_W, const MapConfig& config)
      : p_W_(p_W), width_m_(config.width_m), squared_(config.field_range_m * config.field_range_m) {
    nearest_.distance_m = config.field_range_m;
  }

  void Show(const VoxelIndex& v, bool unknown) {
    const Vector3d lo = Vector3d(v.x, v.y, v.z) * width_m_;
    const Vector3d closest = p_W_.cwiseMax(lo).cwiseMin((lo.array() + width_m_).matrix());
    const double squared = (p_W_ - closest).squaredNorm();
    if (squared < squared_) {
      squared_ = squared;
      nearest_.p_W = closest;
      nearest_.voxel = v;
      nearest_.unknown = unknown;
      nearest_.any = true;
    }
  }

  Nearest Result() {
    if (nearest_.any) {
      nearest_.distance_m = std::sqrt(squared_);
      if (squared_ > 0) {
        nearest_.direction_W = (p_W_ - nearest_.p_W) / nearest_.distance_m;
      }
    }
    return nearest_;
  }

 private:
  Vector3d p_W_;
  double width_m_;
  double squared_;
  Nearest nearest_;
};

// The cell of a coordinate and its neighbours, as offsets into n cells from lo.
struct CellRange {
  int first;
  int own;
  int last;
};

CellRange Around(double coordinate, int lo, int n, double width_m) {
  const double cell = std::floor(coordinate / width_m) - lo;
  const int own = static_cast<int>(std::clamp<double>(cell, 0, n - 1));
  return {std::max(own - 1, 0), own, std::min(own + 1, n - 1)};
}

Nearest KnowsNothing(const Vector3d& p_W) {
  Nearest nearest;
  nearest.p_W = p_W;
  nearest.unknown = true;
  nearest.any = true;
  return nearest;
}

}  // namespace

Nearest DistanceField::NearestObstacle(const Vector3d& p_W) const {
  if (empty() || !p_W.allFinite()) {
    return KnowsNothing(p_W);
  }
  NearestBox nearest(p_W, config_);
  const CellRange x = Around(p_W.x(), config_.lo.x, nx_, config_.width_m);
  const CellRange y = Around(p_W.y(), config_.lo.y, ny_, config_.width_m);
  const CellRange z = Around(p_W.z(), config_.lo.z, nz_, config_.width_m);
  int shown = -1;
  for (int k = z.first; k <= z.last; ++k) {
    for (int j = y.first; j <= y.last; ++j) {
      for (int i = x.first; i <= x.last; ++i) {
        const Packed cell = cells_[i + nx_ * (j + ny_ * k)];
        const VoxelIndex at{i + Offset(cell, 0), j + Offset(cell, 1), k + Offset(cell, 2)};
        const int index = at.x + nx_ * (at.y + ny_ * at.z);
        if (cell < kNone && index != shown) {
          nearest.Show({config_.lo.x + at.x, config_.lo.y + at.y, config_.lo.z + at.z},
                       UnknownAt(index));
          shown = index;
        }
      }
    }
  }
  for (int axis = 0; config_.outside_is_obstacle && axis < 3; ++axis) {
    for (const VoxelIndex& wall : WallsAt(p_W, axis, 3)) {
      nearest.Show(wall, true);
    }
  }
  return nearest.Result();
}

Nearest DistanceField::NearestColumn(double x_m, double y_m) const {
  const Vector3d p_W(x_m, y_m, 0);
  if (empty() || !p_W.allFinite()) {
    return KnowsNothing(p_W);
  }
  NearestBox nearest(p_W, config_);
  const CellRange x = Around(x_m, config_.lo.x, nx_, config_.width_m);
  const CellRange y = Around(y_m, config_.lo.y, ny_, config_.width_m);
  for (int j = y.first; j <= y.last; ++j) {
    for (int i = x.first; i <= x.last; ++i) {
      const Packed cell = columns_[i + nx_ * j];
      if (cell < kNone) {
        const VoxelIndex at{i + Offset(cell, 0), j + Offset(cell, 1), 0};
        const bool unknown = column_unknown_[at.x + nx_ * at.y] != 0;
        nearest.Show({config_.lo.x + at.x, config_.lo.y + at.y, 0}, unknown);
      }
    }
  }
  for (int axis = 0; config_.outside_is_obstacle && axis < 2; ++axis) {
    for (VoxelIndex wall : WallsAt(p_W, axis, 2)) {
      wall.z = 0;
      nearest.Show(wall, true);
    }
  }
  return nearest.Result();
}

// The voxels outside the box, below and above it along an axis, that are nearest to P; P's own
// where P is outside.
std::array<VoxelIndex, 2> DistanceField::WallsAt(const Vector3d& p_W, int axis, int axes) const {
  const int lo[3] = {config_.lo.x, config_.lo.y, config_.lo.z};
  const int n[3] = {nx_, ny_, nz_};
  int at[3];
  bool outside = false;
  for (int i = 0; i < 3; ++i) {
    const double cell = std::floor(p_W[i] / config_.width_m);
    at[i] = static_cast<int>(std::clamp(cell, -1e6, 1e6));
    outside |= i < axes && (at[i] < lo[i] || at[i] >= lo[i] + n[i]);
  }
  const VoxelIndex own{at[0], at[1], at[2]};
  if (outside) {
    return {own, own};
  }
  at[axis] = lo[axis] - 1;
  const VoxelIndex below{at[0], at[1], at[2]};
  at[axis] = lo[axis] + n[axis];
  return {below, VoxelIndex{at[0], at[1], at[2]}};
}

double DistanceField::DistanceAtLeast(const Vector3d& p_W) const {
  if (empty() || !p_W.allFinite()) {
    return 0;
  }
  const double width = config_.width_m;
  const int x = Around(p_W.x(), config_.lo.x, nx_, width).own;
  const int y = Around(p_W.y(), config_.lo.y, ny_, width).own;
  const int z = Around(p_W.z(), config_.lo.z, nz_, width).own;
  const Packed cell = cells_[x + nx_ * (y + ny_ * z)];
  // The distance to anything in the box is at least that of P's projection onto the box, and no
  // point of one voxel is farther from its centre than half a diagonal.
  constexpr double kDiagonal = 1.7320508075688773;
  double least =
      std::min(width * std::sqrt(SquaredDistance(cell)), config_.field_range_m) - width * kDiagonal;
  if (config_.outside_is_obstacle) {
    const Vector3d lo = Vector3d(config_.lo.x, config_.lo.y, config_.lo.z) * width;
    const Vector3d hi = Vector3d(config_.hi.x + 1, config_.hi.y + 1, config_.hi.z + 1) * width;
    least = std::min({least, (p_W - lo).minCoeff(), (hi - p_W).minCoeff()});
  }
  return std::max(least, 0.0);
}

}  // namespace pipewright
