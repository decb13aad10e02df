// SPDX-License-Identifier: MIT
#include "plan/gain/surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/map/voxel_grid.h"
#include "perception/scene.h"

namespace pipewright {
namespace {

constexpr int kFaces = 6;

VoxelIndex Beside(const VoxelIndex& v, int face, int steps = 1) {
  const int step = face % 2 == 0 ? -steps : steps;
  return {v.x + (face / 2 == 0 ? step : 0), v.y + (face / 2 == 1 ? step : 0),
          v.z + (face / 2 == 2 ? step : 0)};
}

std::size_t CountOf(const MapConfig& map) {
  const VoxelIndex& lo = map.workspace_lo;
  const VoxelIndex& hi = map.workspace_hi;
  return static_cast<std::size_t>(VoxelsAlong(lo.x, hi.x)) * VoxelsAlong(lo.y, hi.y) *
         VoxelsAlong(lo.z, hi.z);
}

}  // namespace

SurfaceToCover::SurfaceToCover(const MapConfig& map, int capacity) : map_(map) {
  patches_.reserve(static_cast<std::size_t>(capacity));
  octants_met_.assign(8 * CountOf(map), 0);
  faces_met_.assign(CountOf(map), 0);
}

/// Place of a voxel of W; -1 outside.
int SurfaceToCover::IndexOf(const VoxelIndex& v) const {
  const VoxelIndex& lo = map_.workspace_lo;
  const VoxelIndex& hi = map_.workspace_hi;
  if (!Within(v, lo, hi)) {
    return -1;
  }
  return v.x - lo.x +
         VoxelsAlong(lo.x, hi.x) * (v.y - lo.y + VoxelsAlong(lo.y, hi.y) * (v.z - lo.z));
}

/// Place of the octant of a voxel of W that holds the point; -1 outside W.
int SurfaceToCover::OctantOf(const Vector3d& p_W) const {
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

VoxelIndex SurfaceToCover::VoxelOf(const Vector3d& p_W) const {
  const Vector3d cell = p_W / map_.width_m;
  return {static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())),
          static_cast<int>(std::floor(cell.z()))};
}

Status SurfaceToCover::Update(const VoxelGrid& map, const Scene& scene, int frames) {
  patches_.clear();
  const bool all = LayFaces(map) && LayPipes(scene, frames);
  return all ? Status::kOk : Status::kFull;
}

bool SurfaceToCover::Lay(const SurfacePatch& patch) {
  if (patches_.size() == patches_.capacity()) {
    return false;
  }
  patches_.push_back(patch);
  return true;
}

/// @returns false when the store is full
bool SurfaceToCover::LayFaces(const VoxelGrid& map) {
  constexpr double kInside = 0.499;  // of a voxel: the patch lies just inside its own
  const VoxelIndex& lo = map_.workspace_lo;
  const VoxelIndex& hi = map_.workspace_hi;
  const auto is_surface = [&](const VoxelIndex& v) {
    const int i = map.IndexOf(v);
    return map.KnownAt(i) && map.ObstacleAt(i);
  };
  const auto is_open = [&](const VoxelIndex& v) {
    return map.InBox(v) && map.KnownAt(map.IndexOf(v)) && !map.ObstacleAt(map.IndexOf(v));
  };
  int index = 0;
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x, ++index) {
        const VoxelIndex v{x, y, z};
        for (int face = 0; is_surface(v) && face < kFaces; ++face) {
          if ((faces_met_[index] >> face & 1) != 0 || !is_open(Beside(v, face))) {
            continue;
          }
          SurfacePatch patch;
          patch.voxel = v;
          patch.face = face;
          patch.n_W = Vector3d::Zero();
          patch.n_W(face / 2) = face % 2 == 0 ? -1 : 1;
          patch.p_W = map.Center(v) + kInside * map_.width_m * patch.n_W;
          if (!Lay(patch)) {
            return false;
          }
        }
      }
    }
  }
  return true;
}

/// @returns false when the store is full
bool SurfaceToCover::LayPipes(const Scene& scene, int frames) {
  // Around finer than along: a sliver of a voxel's surface may be all of it that can be met.
  const double along_spacing_m = map_.width_m / 2;
  const double around_spacing_m = map_.width_m / 4;
  for (const PipeEstimate& pipe : scene.pipes) {
    const double length_m = pipe.extent_hi_m - pipe.extent_lo_m;
    if (pipe.frames_seen < frames || !(length_m > 0) || !(pipe.radius_m > 0)) {
      continue;
    }
    const Vector3d e1 = pipe.l_W.unitOrthogonal();
    const Vector3d e2 = pipe.l_W.cross(e1);
    const double round_m = 2 * std::numbers::pi * std::min(pipe.radius_m, 1.0);
    const int around = std::max(12, static_cast<int>(std::ceil(round_m / around_spacing_m)));
    const int along = static_cast<int>(std::ceil(std::min(length_m, 1e3) / along_spacing_m));
    for (int i = 0; i < along * around; ++i) {
      const int ring = i / around;
      const double angle = 2 * std::numbers::pi * (i % around) / around;
      const double at_m = pipe.extent_lo_m + length_m * (ring + 0.5) / along;
      SurfacePatch patch;
      patch.n_W = std::cos(angle) * e1 + std::sin(angle) * e2;
      patch.p_W = pipe.p_W + at_m * pipe.l_W + pipe.radius_m * patch.n_W;
      patch.voxel = VoxelOf(patch.p_W);
      const int octant = OctantOf(patch.p_W);
      if (octant >= 0 && octants_met_[octant] == 0 && !Lay(patch)) {
        return false;
      }
    }
  }
  return true;
}

void SurfaceToCover::MarkMet(const SurfacePatch& patch) {
  if (patch.face >= 0) {
    for (const int steps : {-1, 0, 1}) {
      const int index = IndexOf(Beside(patch.voxel, patch.face, steps));
      if (index >= 0) {
        faces_met_[index] = static_cast<std::uint8_t>(faces_met_[index] | 1 << patch.face);
      }
    }
    return;
  }
  constexpr double kSettle_m = 0.01;
  for (const double along_m : {-kSettle_m, 0.0, kSettle_m}) {
    const int octant = OctantOf(patch.p_W + along_m * patch.n_W);
    if (octant >= 0) {
      octants_met_[octant] = 1;
    }
  }
}

}  // namespace pipewright
