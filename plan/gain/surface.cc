// SPDX-License-Identifier: MIT
#include "plan/gain/surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/scene.h"

namespace pipewright {

PipeSurface::PipeSurface(const MapConfig& map, int capacity) : map_(map) {
  patches_.reserve(static_cast<std::size_t>(capacity));
  const VoxelIndex& lo = map.workspace_lo;
  const VoxelIndex& hi = map.workspace_hi;
  const int voxels = VoxelsAlong(lo.x, hi.x) * VoxelsAlong(lo.y, hi.y) * VoxelsAlong(lo.z, hi.z);
  met_.assign(static_cast<std::size_t>(8 * voxels), 0);
}

/// Place of the octant of a voxel of W that holds the point, in met_; -1 outside W.
int PipeSurface::OctantOf(const Vector3d& p_W) const {
  const VoxelIndex& lo = map_.workspace_lo;
  const VoxelIndex& hi = map_.workspace_hi;
  const Vector3d halves = p_W * (2 / map_.width_m) - 2 * Vector3d(lo.x, lo.y, lo.z);
  const int nx = 2 * VoxelsAlong(lo.x, hi.x);
  const int ny = 2 * VoxelsAlong(lo.y, hi.y);
  const int nz = 2 * VoxelsAlong(lo.z, hi.z);
  if (!(halves.array() >= 0).all() || !(halves.x() < nx && halves.y() < ny && halves.z() < nz)) {
    return -1;
  }
  return static_cast<int>(halves.x()) +
         nx * (static_cast<int>(halves.y()) + ny * static_cast<int>(halves.z()));
}

VoxelIndex PipeSurface::VoxelOf(const Vector3d& p_W) const {
  const Vector3d cell = p_W / map_.width_m;
  return {static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())),
          static_cast<int>(std::floor(cell.z()))};
}

Status PipeSurface::Update(const Scene& scene, int frames) {
  const double spacing_m = map_.width_m / 2;
  patches_.clear();
  for (const PipeEstimate& pipe : scene.pipes) {
    const double length_m = pipe.extent_hi_m - pipe.extent_lo_m;
    if (pipe.frames_seen < frames || !(length_m > 0) || !(pipe.radius_m > 0)) {
      continue;
    }
    const Vector3d e1 = pipe.l_W.unitOrthogonal();
    const Vector3d e2 = pipe.l_W.cross(e1);
    const double round_m = 2 * std::numbers::pi * pipe.radius_m;
    const int around = std::max(6, static_cast<int>(std::ceil(round_m / spacing_m)));
    const int along = static_cast<int>(std::ceil(std::min(length_m, 1e3) / spacing_m));
    for (int i = 0; i < along * around; ++i) {
      const double angle = 2 * std::numbers::pi * (i % around) / around;
      const double at_m = pipe.extent_lo_m + length_m * (i / around + 0.5) / along;
      SurfacePatch patch;
      patch.n_W = std::cos(angle) * e1 + std::sin(angle) * e2;
      patch.p_W = pipe.p_W + at_m * pipe.l_W + pipe.radius_m * patch.n_W;
      patch.voxel = VoxelOf(patch.p_W);
      const int octant = OctantOf(patch.p_W);
      if (octant < 0 || met_[octant] != 0) {
        continue;
      }
      if (patches_.size() == patches_.capacity()) {
        return Status::kFull;
      }
      patches_.push_back(patch);
    }
  }
  return Status::kOk;
}

void PipeSurface::MarkMet(const SurfacePatch& patch) {
  constexpr double kSettle_m = 0.01;
  for (const double along_m : {-kSettle_m, 0.0, kSettle_m}) {
    const int octant = OctantOf(patch.p_W + along_m * patch.n_W);
    if (octant >= 0) {
      met_[octant] = 1;
    }
  }
}

}  // namespace pipewright
