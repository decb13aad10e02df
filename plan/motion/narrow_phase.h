// SPDX-License-Identifier: MIT
#pragma once

#include "perception/map/voxel_grid.h"
#include "platform/core/frames.h"
#include "platform/robot/shapes.h"

namespace pipewright {

/// Whether a shape at X_WG, grown by margin_m on all sides, meets the box of an obstacle voxel.
/// libccd's GJK on support functions: no heap, at most 100 rounds a voxel. Only voxels that the
/// distance to their centre cannot settle are given to it.
bool MeetsObstacle(const BodyShape& shape, const Isometry3d& X_WG, double margin_m,
                   const VoxelGrid& map);

/// Distance between the segments a0-a1 and b0-b1. [Ericson: Real-Time Collision Detection, 5.1.9]
double SegmentDistance(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                       const Vector3d& b1);

/// Distance between the segment a0-a1 and a box about the origin, 0 where they meet, to 1e-4 m.
double SegmentBoxDistance(const Vector3d& a0, const Vector3d& a1, const Vector3d& half_m);

}  // namespace pipewright
