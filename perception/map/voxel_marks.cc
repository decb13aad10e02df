// SPDX-License-Identifier: MIT
// What is marked in the map beside what its rays tell: swept, covered, residual.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "perception/map/ray_walk.h"

namespace pipewright {
namespace {

/// Bits [bit, bit + count) of a plane, count <= 9; the plane has a byte to spare.
unsigned BitsAt(const void* plane, int bit, int count) {
  std::uint16_t bits = 0;
  std::memcpy(&bits, static_cast<const unsigned char*>(plane) + (bit >> 3), sizeof bits);
  return (bits >> (bit & 7)) & ((1U << count) - 1);
}

double SquaredDistanceToBox(const Vector3d& p, const Vector3d& center, double half_width) {
  return ((p - center).cwiseAbs().array() - half_width).max(0.0).matrix().squaredNorm();
}

}  // namespace

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
          Touch(BrickOf({x, y, z}));
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
        if (KnownAt(index) && !Flag(index) && !InTheOpen({x, y, z}) &&
            Sees(p_WP, radius_m, {x, y, z})) {
          SetProbed(index, {x, y, z});
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

bool VoxelGrid::InTheOpen(const VoxelIndex& v) const {
  constexpr unsigned kThreeFree = kKnown | kKnown << 2 | kKnown << 4;
  const VoxelIndex& lo = config_.lo;
  const VoxelIndex& hi = config_.hi;
  if (!Within(v, {lo.x + 1, lo.y + 1, lo.z + 1}, {hi.x - 1, hi.y - 1, hi.z - 1})) {
    return false;
  }
  const int before = IndexOf(v) - 1;
  for (const int row : {0, -nx_, nx_}) {
    for (const int layer : {0, -nx_ * ny_, nx_ * ny_}) {
      if (BitsAt(codes_.data(), 2 * (before + row + layer), 6) != kThreeFree) {
        return false;
      }
    }
  }
  return true;
}

void VoxelGrid::SetProbed(int index, const VoxelIndex& v) {
  SetFlag(index, true);
  const VoxelIndex& lo = config_.lo;
  const VoxelIndex& hi = config_.hi;
  for (const int z : {std::max(v.z - 1, lo.z), std::min(v.z + 1, hi.z)}) {
    for (const int y : {std::max(v.y - 1, lo.y), std::min(v.y + 1, hi.y)}) {
      for (const int x : {std::max(v.x - 1, lo.x), std::min(v.x + 1, hi.x)}) {
        probed_near_[BrickOf({x, y, z})] = 1;
      }
    }
  }
}

// What has come to be in the open by that this one turned free.
void VoxelGrid::ForgetProbedInTheOpen(const VoxelIndex& around) {
  const VoxelIndex& lo = config_.lo;  // whose outermost voxels are never in the open
  const VoxelIndex& hi = config_.hi;
  for (int z = std::max(around.z - 1, lo.z + 1); z <= std::min(around.z + 1, hi.z - 1); ++z) {
    for (int y = std::max(around.y - 1, lo.y + 1); y <= std::min(around.y + 1, hi.y - 1); ++y) {
      const int index = IndexOf({around.x - 1, y, z});
      for (unsigned left = BitsAt(flags_.data(), index, 3); left != 0; left &= left - 1) {
        const int i = __builtin_ctz(left);
        if (InTheOpen({around.x - 1 + i, y, z})) {
          SetFlag(index + i, false);
        }
      }
    }
  }
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

}  // namespace pipewright
