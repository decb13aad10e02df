// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plan/gain/gain.h"

namespace pipewright {

/// Which voxels of W views have failed to settle, and near which views the robot stalled.
///
/// Two counts a voxel: views that the robot was at and that should have settled it, and
/// views that had no path (forgotten when the map has grown, since a way may have opened). A voxel
/// with `tries` of either does not count any more. Capacities: |W| bytes three times, kStalls
/// views.
class Failures {
 public:
  Failures(int workspace_voxels, int tries, double stall_radius_m);

  std::span<std::uint8_t> unsettled() { return unsettled_; }
  std::span<std::uint8_t> pathless() { return pathless_; }
  void ForgetPathless();
  /// Views that settled nothing and stalls, too.
  void ForgetAll();

  /// Brings Ignored() up to date with the counts.
  void Refresh();
  std::span<const std::uint8_t> Ignored() const { return ignored_; }

  /// A view that was not reached; when full, the oldest is forgotten.
  void AddStall(const Viewpoint& view);
  /// Stalls with their sensor within the radius and their axis within 37 deg of the view's.
  int StallsNear(const Viewpoint& view) const;

 private:
  static constexpr int kStalls = 64;
  struct Stall {
    Vector3d p_WS = Vector3d::Zero();
    Vector3d z_WS = Vector3d::Zero();
  };

  int tries_;
  double stall_radius_m_;
  std::vector<std::uint8_t> unsettled_;
  std::vector<std::uint8_t> pathless_;
  std::vector<std::uint8_t> ignored_;
  Stall stalls_[kStalls];
  int stall_count_ = 0;  ///< ever; the newest kStalls are held
};

}  // namespace pipewright
