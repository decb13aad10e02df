// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/map/voxel_index.h"
#include "platform/core/status.h"

namespace pipewright {

struct Scene;

/// A spot of a surface, and the way it faces.
struct SurfacePatch {
  Vector3d p_W = Vector3d::Zero();
  Vector3d n_W = Vector3d::UnitZ();  ///< outwards, unit
  VoxelIndex voxel;
};

/// The surface that the scene's pipes must have, seen or not, in W, and what the probe met of it.
///
/// The map calls a voxel free that rays graze on their way, though the far side of a pipe may cross
/// it: such surface would never be covered. An estimated cylinder says where it is. Its seen length
/// is laid out in patches half a voxel apart; a patch is met once the probe was within its radius,
/// on the side it faces, with nothing before it. What is met is remembered by octants of voxels,
/// with those 10 mm to either side along the normal, so that an estimate that settles by a few
/// millimetres does not bring back what was met.
///
/// Memory: `capacity` patches and 8 |W| bytes, taken at construction. What is beyond is left out.
class PipeSurface {
 public:
  explicit PipeSurface(const MapConfig& map, int capacity = 8192);

  /// Lays out the patches of W that are not met yet, of pipes seen in at least `frames` frames.
  /// @returns kFull when not all fit
  Status Update(const Scene& scene, int frames);

  std::span<const SurfacePatch> patches() const { return patches_; }
  void MarkMet(const SurfacePatch& patch);

 private:
  int OctantOf(const Vector3d& p_W) const;
  VoxelIndex VoxelOf(const Vector3d& p_W) const;

  MapConfig map_;
  std::vector<SurfacePatch> patches_;
  std::vector<std::uint8_t> met_;
};

}  // namespace pipewright
