// SPDX-License-Identifier: MIT
#pragma once

#include "perception/localization/fix_gain.h"

namespace pipewright {

/// Fixes that contradict the pose, and whether they agree with one another on where the base is.
///
/// A false fix is alone, or wanders from frame to frame; the fixes of a base that was moved all
/// tell the same offset from the pose that its wheels tell. Two are of one opinion when the second
/// is within the gate of GainOf() about the pose plus the first one's offset, with what a base that
/// brakes may do between two frames as M.
class Dissent {
 public:
  /// A fix beyond the gate about this pose of its instant.
  void Add(const PoseFix& fix, const Vector3d& pose, const FixNoiseConfig& noise);
  void Clear() { count_ = 0; }

  /// In a row, of one opinion.
  int count() const { return count_; }
  /// Of the last: fix less pose.
  const Vector3d& offset() const { return offset_; }

 private:
  int count_ = 0;
  Vector3d offset_ = Vector3d::Zero();
};

}  // namespace pipewright
