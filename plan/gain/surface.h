// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/map/voxel_index.h"
#include "platform/core/status.h"

namespace pipewright {

struct Scene;
class VoxelGrid;

/// A spot of a surface, and the way it faces.
struct SurfacePatch {
  Vector3d p_W = Vector3d::Zero();
  Vector3d n_W = Vector3d::UnitZ();  ///< outwards, unit
  VoxelIndex voxel;
  int face = -1;  ///< of a voxel, 0 ... 5: -x +x -y +y -z +z; -1: a pipe's
};

/// The surface of W that the probe has not met yet, all sides of it.
///
/// A voxel is covered once the probe saw it, from whichever side; and the map calls a voxel free
/// that rays graze on their way, though the far side of a pipe may cross it. So that no side is
/// left out, surface is laid out in patches that face somewhere:
///   - each face between a surface's voxel (occupied, or solid) and a known free one;
///   - the seen length of each estimated pipe, all around, half a voxel apart along and a quarter
///   around.
/// A patch is met once the probe was within its radius, on the side it faces, with nothing before
/// it. Faces are remembered with those of the next voxel in front and behind, patches of pipes by
/// octants of voxels, with those 10 mm to either side: a map or an estimate that settles does not
/// bring back what was met.
///
/// Memory: `capacity` patches and 9 |W| bytes, taken at construction. What is beyond is left out.
class SurfaceToCover {
 public:
  explicit SurfaceToCover(const MapConfig& map, int capacity = 16384);

  /// Lays out the patches that are not met yet; pipes if seen in at least `frames` frames.
  /// @returns kFull when not all fit
  Status Update(const VoxelGrid& map, const Scene& scene, int frames);

  std::span<const SurfacePatch> patches() const { return patches_; }
  void MarkMet(const SurfacePatch& patch);

 private:
  bool LayFaces(const VoxelGrid& map);
  bool LayPipes(const Scene& scene, int frames);
  bool Lay(const SurfacePatch& patch);
  int OctantOf(const Vector3d& p_W) const;
  VoxelIndex VoxelOf(const Vector3d& p_W) const;
  int IndexOf(const VoxelIndex& v) const;

  MapConfig map_;
  std::vector<SurfacePatch> patches_;
  std::vector<std::uint8_t> octants_met_;
  std::vector<std::uint8_t> faces_met_;  ///< a bit a face
};

}  // namespace pipewright
