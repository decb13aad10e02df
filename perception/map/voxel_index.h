// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/core/frames.h"

namespace pipewright {

using Eigen::Vector3f;

/// Voxel (x, y, z) holds P when floor(p_WP / width) = (x, y, z): half open, absolute in W.
/// An OctoMap key is this plus 32768 per axis.
struct VoxelIndex {
  int x = 0;
  int y = 0;
  int z = 0;

  friend constexpr bool operator==(const VoxelIndex&, const VoxelIndex&) = default;
};

/// Unknown: no ray has passed or ended in it yet.
enum class VoxelState : std::uint8_t { kUnknown, kFree, kOccupied };

/// Whether lo <= v <= hi on every axis.
constexpr bool Within(const VoxelIndex& v, const VoxelIndex& lo, const VoxelIndex& hi) {
  return lo.x <= v.x && v.x <= hi.x && lo.y <= v.y && v.y <= hi.y && lo.z <= v.z && v.z <= hi.z;
}

/// What the map stores, and OctoMap's sensor model. Boxes are inclusive on both sides.
struct MapConfig {
  VoxelIndex lo{0, 0, 0};  ///< the box that is stored: five bits a voxel, used or not
  VoxelIndex hi{29, 29, 29};
  VoxelIndex workspace_lo{0, 0, 0};  ///< W: what counts() and the entropies speak of
  VoxelIndex workspace_hi{29, 29, 29};
  double width_m = 0.05;
  int brick_capacity = 64;  ///< bricks of 8x8x8 log-odds; BricksOfBox() is enough for every voxel
  double p_hit = 0.7;       ///< OctoMap 1.9.7's defaults, all five
  double p_miss = 0.4;
  double p_min = 0.1192;
  double p_max = 0.971;  ///< these two from 0.001 to 0.999: log-odds of any build hold them
  double p_occupied = 0.5;
  bool outside_is_obstacle = false;  ///< what Obstacle() says of a voxel outside the stored box
  double field_range_m = 1.0;        ///< how far the distance field looks, at most 30 widths
  double column_lo_m = 0.05;         ///< obstacles with a centre between these heights are in the
  double column_hi_m = 0.30;         ///< base's way: the column field holds them
};

constexpr int VoxelsAlong(int lo, int hi) { return hi - lo + 1; }

/// Bricks that touch the stored box: with this capacity none is ever refused.
constexpr int BricksOfBox(const MapConfig& c) {
  return ((c.hi.x >> 3) - (c.lo.x >> 3) + 1) * ((c.hi.y >> 3) - (c.lo.y >> 3) + 1) *
         ((c.hi.z >> 3) - (c.lo.z >> 3) + 1);
}

/// Whether the stored box ends with bricks: then it can move.
constexpr bool WholeBricks(const MapConfig& c) {
  return (c.lo.x & 7) == 0 && (c.lo.y & 7) == 0 && (c.lo.z & 7) == 0 &&  //
         (c.hi.x & 7) == 7 && (c.hi.y & 7) == 7 && (c.hi.z & 7) == 7;
}

constexpr bool Valid(const MapConfig& c) {
  constexpr int kReach = 1 << 15;  // OctoMap's 16-bit keys
  constexpr double kVoxelsMax = 1 << 27;
  return Within(c.lo, {-kReach, -kReach, -kReach}, c.hi) &&
         Within(c.hi, c.lo, {kReach - 1, kReach - 1, kReach - 1}) &&
         Within(c.workspace_lo, c.lo, c.workspace_hi) &&
         Within(c.workspace_hi, c.workspace_lo, c.hi) &&
         1.0 * VoxelsAlong(c.lo.x, c.hi.x) * VoxelsAlong(c.lo.y, c.hi.y) *
                 VoxelsAlong(c.lo.z, c.hi.z) <=
             kVoxelsMax &&
         c.width_m > 0 && c.brick_capacity > 0 &&  //
         0.001 < c.p_min && c.p_min < c.p_miss && c.p_miss < 0.5 && 0.5 < c.p_hit &&
         c.p_hit < c.p_max && c.p_max < 0.999 && c.p_min < c.p_occupied && c.p_occupied < c.p_max &&
         c.field_range_m >= c.width_m && c.field_range_m <= 30 * c.width_m &&
         c.column_lo_m <= c.column_hi_m;
}

/// The box of whole voxels that holds [lo, hi] in W, grown by `margin` voxels.
struct VoxelBox {
  VoxelIndex lo;
  VoxelIndex hi;
};
VoxelBox BoxOf(const Vector3d& lo_W, const Vector3d& hi_W, double width_m, int margin = 0);

}  // namespace pipewright
