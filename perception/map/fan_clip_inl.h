// SPDX-License-Identifier: MIT
// Only for fan_kernels_inl.h: points to the voxels that hold them and to the ends of their rays.
#include "perception/map/fan_exact_inl.h"

namespace pipewright::fan::PIPEWRIGHT_FAN_ISA {
namespace {

/// The box in registers, and the way from a voxel to its place in what is marked.
struct CellFinder {
  explicit CellFinder(const Origin& o) {
    int begin = o.index;
    for (int a = 0; a < 3; ++a) {
      lo[a] = Counts{} + (o.voxel[a] - o.to_wall[0][a]);
      hi[a] = Counts{} + (o.voxel[a] + o.to_wall[1][a]);
      stride[a] = Bits{} + static_cast<std::uint32_t>(o.stride[a]);
      begin -= o.voxel[a] * o.stride[a];
    }
    start = Bits{} + static_cast<std::uint32_t>(begin);
    width_inv = Doubles{} + o.width_inv;
  }

  /// Of kHalf points; -1 outside the box.
  Counts Find(const float* points_W) const {
    Counts outside = {};
    Bits index = start;
    for (int a = 0; a < 3; ++a) {
      const Counts voxel = Floor(width_inv * ToDoubles(Coordinates(points_W, a)));
      outside |= (voxel < lo[a]) | (voxel > hi[a]);
      index += (Bits)voxel * stride[a];
    }
    return (Counts)index | outside;
  }

  Counts lo[3];
  Counts hi[3];
  Bits stride[3];
  Bits start;
  Doubles width_inv;
};

/// Clips kHalf points at the range. @returns ones for those that were
inline Counts ClipHalf(const Origin& o, const float* points_W, double max_range_m, float* ends_W) {
  Floats p[3];
  Floats along[3];
  for (int a = 0; a < 3; ++a) {
    p[a] = Coordinates(points_W, a);
    along[a] = p[a] - o.p_W[a];
  }
  const Floats squared = along[0] * along[0] + along[1] * along[1] + along[2] * along[2];
  const Doubles distance = SquareRoot(ToDoubles(squared));
  const Floats length = ToFloats(distance);
  const Counts within = __builtin_convertvector(distance <= max_range_m, Counts);
  const Counts divide = __builtin_convertvector(distance > 0, Counts);
  const auto range = static_cast<float>(max_range_m);
  for (int a = 0; a < 3; ++a) {
    const Floats direction = divide ? along[a] / length : along[a];
    const Floats end = within ? p[a] : o.p_W[a] + direction * range;
    for (int l = 0; l < kHalf; ++l) {
      ends_W[3 * l + a] = end[l];
    }
  }
  return ~within;
}

}  // namespace
}  // namespace pipewright::fan::PIPEWRIGHT_FAN_ISA
