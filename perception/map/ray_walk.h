// SPDX-License-Identifier: MIT
#pragma once

#include "perception/map/voxel_grid.h"

namespace pipewright {

/// The voxels that a segment passes, in order, exactly as OctoMap's computeRayKeys gives them: the
/// origin's voxel first, the end's voxel left out, none at all when both lie in one voxel.
///
///   for (RayWalk ray(grid, a, b); ray.Next();) { ... ray.voxel() ... ray.index() ... }
///
/// Amanatides, Woo: A fast voxel traversal algorithm for ray tracing (1987). Numbers as OctoMap's:
/// direction in float, crossings in double, ties to the later axis. A few ns per voxel; no heap.
class RayWalk {
 public:
  RayWalk(const VoxelGrid& grid, const Vector3f& origin_W, const Vector3f& end_W);

  /// Steps to the next voxel (the first call: to the origin's). False: there is none.
  bool Next();

  VoxelIndex voxel() const { return {at_[0], at_[1], at_[2]}; }
  /// Flat index into the grid, or -1 outside its box.
  int index() const { return inside_ ? static_cast<int>(index_) : -1; }
  /// Whether the voxel lies in the grid's stored box.
  bool inside() const { return inside_; }

 private:
  bool Inside() const { return Within({at_[0], at_[1], at_[2]}, lo_, hi_); }

  VoxelIndex lo_;
  VoxelIndex hi_;
  int at_[3] = {0, 0, 0};
  int end_[3] = {0, 0, 0};
  int step_[3] = {0, 0, 0};
  std::int64_t stride_[3] = {0, 0, 0};
  double t_next_[3] = {0, 0, 0};   // length along the ray to the next crossing, per axis
  double t_delta_[3] = {0, 0, 0};  // and from one crossing to the next
  double length_ = 0;
  std::int64_t index_ = 0;
  bool inside_ = false;
  enum class Phase { kFirst, kWalking, kDone } phase_ = Phase::kDone;
};

inline bool RayWalk::Next() {
  if (phase_ != Phase::kWalking) {
    const bool first = phase_ == Phase::kFirst;
    phase_ = first ? Phase::kWalking : Phase::kDone;
    return first;
  }
  int axis = t_next_[0] < t_next_[1] ? 0 : 1;
  axis = t_next_[axis] < t_next_[2] ? axis : 2;
  at_[axis] += step_[axis];
  index_ += stride_[axis];
  t_next_[axis] += t_delta_[axis];
  const double nearer = t_next_[0] < t_next_[1] ? t_next_[0] : t_next_[1];
  if ((at_[0] == end_[0] && at_[1] == end_[1] && at_[2] == end_[2]) ||
      (nearer < t_next_[2] ? nearer : t_next_[2]) > length_) {
    phase_ = Phase::kDone;
    return false;
  }
  inside_ = Inside();
  return true;
}

}  // namespace pipewright
