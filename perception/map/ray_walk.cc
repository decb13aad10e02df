// SPDX-License-Identifier: MIT
#include "perception/map/ray_walk.h"

#include <limits>

#include "perception/map/key_math.h"

namespace pipewright {

RayWalk::RayWalk(const VoxelGrid& grid, const Vector3f& origin_W, const Vector3f& end_W)
    : lo_(grid.config().lo), hi_(grid.config().hi) {
  const double width = grid.config().width_m;
  VoxelIndex from;
  VoxelIndex to;
  if (!key_math::VoxelOf(origin_W, 1 / width, &from) || !key_math::VoxelOf(end_W, 1 / width, &to) ||
      from == to) {
    return;
  }
  const Vector3f along = end_W - origin_W;
  const auto length = static_cast<float>(key_math::Norm(along));
  if (!(length > 0)) {
    return;  // across a border, but shorter than float's squares can tell
  }
  const Vector3f direction = key_math::Divided(along, length);
  const int from_axes[3] = {from.x, from.y, from.z};
  const int to_axes[3] = {to.x, to.y, to.z};
  const std::int64_t strides[3] = {1, grid.nx_, std::int64_t{grid.nx_} * grid.ny_};
  for (int i = 0; i < 3; ++i) {
    at_[i] = from_axes[i];
    end_[i] = to_axes[i];
    t_next_[i] = t_delta_[i] = std::numeric_limits<double>::max();
    if (direction[i] != 0) {
      step_[i] = direction[i] > 0 ? 1 : -1;
      stride_[i] = step_[i] * strides[i];
      const double border =
          key_math::Center(at_[i], width) + static_cast<float>(step_[i] * width * 0.5);
      const double d = direction[i];
      t_next_[i] = (border - static_cast<double>(origin_W[i])) / d;
      t_delta_[i] = width / std::abs(d);
    }
  }
  length_ = length;
  index_ = grid.FlatIndex(from);
  inside_ = Inside();
  phase_ = Phase::kFirst;
}

}  // namespace pipewright
