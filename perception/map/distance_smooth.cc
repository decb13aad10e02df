// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/map/distance_cell.h"
#include "perception/map/distance_field.h"

namespace pipewright {

// Between the centre of a cell, counted from the box's corner, and that of its nearest obstacle.
double DistanceField::CenterDistance(const VoxelIndex& cell) const {
  const VoxelIndex last{nx_ - 1, ny_ - 1, nz_ - 1};
  const bool outside = !Within(cell, {0, 0, 0}, last);
  if (outside && config_.outside_is_obstacle) {
    return 0;
  }
  const VoxelIndex at{std::clamp(cell.x, 0, last.x), std::clamp(cell.y, 0, last.y),
                      std::clamp(cell.z, 0, last.z)};
  double widths =
      std::sqrt(distance_cell::SquaredDistance(cells_[at.x + nx_ * (at.y + ny_ * at.z)]));
  if (config_.outside_is_obstacle) {
    const int wall = std::min({at.x, last.x - at.x, at.y, last.y - at.y, at.z, last.z - at.z}) + 1;
    widths = std::min(widths, static_cast<double>(wall));
  }
  return std::min(widths * config_.width_m, config_.field_range_m);
}

SmoothDistance DistanceField::Interpolate(const Vector3d& p_W) const {
  if (empty() || !p_W.allFinite()) {
    return {};
  }
  // In widths from the centre of the box's first cell; beyond the box by two, all goes on as it is.
  const Vector3d size(nx_, ny_, nz_);
  const Vector3d first(config_.lo.x + 0.5, config_.lo.y + 0.5, config_.lo.z + 0.5);
  const Vector3d p = (p_W / config_.width_m - first)
                         .cwiseMax(Vector3d::Constant(-2))
                         .cwiseMin(size + Vector3d::Ones());
  const Vector3d floor = p.array().floor();
  const Vector3d part = p - floor;
  const VoxelIndex at{static_cast<int>(floor.x()), static_cast<int>(floor.y()),
                      static_cast<int>(floor.z())};
  SmoothDistance smooth;
  for (int corner = 0; corner < 8; ++corner) {
    const int up[3] = {corner & 1, (corner >> 1) & 1, corner >> 2};
    const double d_m = CenterDistance({at.x + up[0], at.y + up[1], at.z + up[2]});
    Vector3d w;
    Vector3d slope;  // of w, per width
    for (int i = 0; i < 3; ++i) {
      w[i] = up[i] != 0 ? part[i] : 1 - part[i];
      slope[i] = up[i] != 0 ? 1 : -1;
    }
    smooth.distance_m += w.prod() * d_m;
    smooth.gradient_W +=
        d_m / config_.width_m *
        Vector3d(slope[0] * w[1] * w[2], w[0] * slope[1] * w[2], w[0] * w[1] * slope[2]);
  }
  return smooth;
}

}  // namespace pipewright
