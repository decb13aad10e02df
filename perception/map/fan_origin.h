// SPDX-License-Identifier: MIT
#pragma once

#include "perception/map/fan_kernels.h"
#include "perception/map/key_math.h"

namespace pipewright {

/// How OctoMap rounds half a voxel on the way to a border: computeRayKeys to float, castRay not.
enum class HalfWidth : std::uint8_t { kFloat, kDouble };

/// What rays from here share; flat indices are those of the box, x fastest. False: the origin is
/// not in the box.
inline bool AimFrom(const MapConfig& box, const Vector3f& origin_W, HalfWidth rounding,
                    fan::Origin* o) {
  VoxelIndex v;
  o->width_m = box.width_m;
  o->width_inv = 1 / box.width_m;
  if (!key_math::VoxelOf(origin_W, o->width_inv, &v) || !Within(v, box.lo, box.hi)) {
    return false;
  }
  const int at[3] = {v.x, v.y, v.z};
  const int lo[3] = {box.lo.x, box.lo.y, box.lo.z};
  const int hi[3] = {box.hi.x, box.hi.y, box.hi.z};
  const double half =
      rounding == HalfWidth::kFloat ? static_cast<float>(box.width_m * 0.5) : box.width_m * 0.5;
  int stride = 1;
  o->index = 0;
  for (int a = 0; a < 3; ++a) {
    const double center_m = key_math::Center(at[a], box.width_m);
    const double origin_m = origin_W[a];
    o->p_W[a] = origin_W[a];
    o->voxel[a] = at[a];
    o->to_border_m[0][a] = center_m - half - origin_m;
    o->to_border_m[1][a] = center_m + half - origin_m;
    o->to_wall[0][a] = at[a] - lo[a];
    o->to_wall[1][a] = hi[a] - at[a];
    o->stride[a] = stride;
    o->index += stride * (at[a] - lo[a]);
    stride *= VoxelsAlong(lo[a], hi[a]);
  }
  return true;
}

}  // namespace pipewright
