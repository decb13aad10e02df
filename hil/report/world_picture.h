// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>
#include <vector>

#include "platform/core/frames.h"

namespace pipewright::hil {

/// What became of a voxel of the world's surface, worst last.
enum class SurfaceState : unsigned char {
  kOutOfReach,  ///< no configuration can cover it
  kCovered,
  kMissed,
};

/// What a picture of the inspected place shows, in W.
struct WorldView {
  Vector3d min_m = Vector3d::Zero();  ///< the workspace
  Vector3d max_m = Vector3d::Zero();
  double voxel_m = 0.05;
  struct Voxel {
    std::array<int, 3> index{};  ///< floor(coordinate / voxel_m)
    SurfaceState state = SurfaceState::kMissed;
  };
  std::vector<Voxel> surface;
  std::vector<std::vector<Vector3d>> outlines;  ///< polylines: edges of walls, pipes
  std::vector<Vector3d> hand_path;
  std::vector<Vector3d> goals;
};

/// Two isometric drawings from opposite corners above, as inline SVG: the surface by state, the
/// hand's way, the goals. Many voxels are drawn in coarser ones that take their worst state, so
/// that the size stays below some 200 kB. Empty when there is nothing to show.
std::string RenderWorld(const WorldView& world);

}  // namespace pipewright::hil
