// SPDX-License-Identifier: MIT
#include "plan/gain/cells.h"

#include <algorithm>

namespace pipewright {
namespace {

int Count(const VoxelIndex& lo, const VoxelIndex& hi) {
  return (hi.x - lo.x + 1) * (hi.y - lo.y + 1) * (hi.z - lo.z + 1);
}

}  // namespace

GainEvaluator::Cells::Cells(const MapConfig& config)
    : map(config),
      nx(config.hi.x - config.lo.x + 3),
      ny(config.hi.y - config.lo.y + 3),
      nz(config.hi.z - config.lo.z + 3),
      workspace_voxels(Count(config.workspace_lo, config.workspace_hi)),
      flags(static_cast<std::size_t>(nx * ny * nz), kBorder),
      marks(flags.size() / 32 + 1, 0),
      taken(flags.size()),
      probe_stamps(flags.size(), 0),
      workspace_index(flags.size(), -1) {
  const VoxelIndex& lo = map.workspace_lo;
  const VoxelIndex& hi = map.workspace_hi;
  for (std::vector<std::uint32_t>& plane : planes) {
    plane.resize(flags.size() / 16 + 1);
  }
  int next = 0;
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        workspace_index[Index({x, y, z})] = next++;
      }
    }
  }
  for (std::vector<VoxelIndex>* list : {&unknown, &frontier, &uncovered}) {
    list->reserve(static_cast<std::size_t>(workspace_voxels));
  }
}

bool GainEvaluator::Cells::Blocked(const Vector3d& origin, const Vector3d& direction,
                                   double length) const {
  bool blocked = false;
  Walk(origin, direction, length, [&](int cell) {
    blocked = (flags[cell] & kOccupied) != 0;
    return !blocked && (flags[cell] & kBorder) == 0;
  });
  return blocked;
}

bool GainEvaluator::Cells::Meets(const Vector3d& origin, const Vector3d& way, int target,
                                 bool through_unknown) const {
  const int stop = kOccupied | kBorder;
  bool met = false;
  Walk(origin, way, 1.0, [&](int cell) {
    met = cell == target;
    const int here = flags[cell];
    return !met && (here & stop) == 0 && (through_unknown || (here & kFree) != 0);
  });
  return met;
}

bool GainEvaluator::Cells::Seen(const Vector3d& origin, const VoxelIndex& v) const {
  constexpr double kToFace = 0.499;  // just inside the voxel
  const int target = Index(v);
  const bool through_unknown = (flags[target] & kFree) == 0;
  const Vector3d way = CenterInCells(v) - origin;
  if (Meets(origin, way, target, through_unknown)) {
    return true;
  }
  for (int axis = 0; axis < 3; ++axis) {
    Vector3d to_face = way;
    to_face[axis] += way[axis] > 0 ? -kToFace : kToFace;
    if (std::abs(way[axis]) > 0.5 && Meets(origin, to_face, target, through_unknown)) {
      return true;
    }
  }
  return false;
}

}  // namespace pipewright
