// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "perception/map/voxel_index.h"

/// OctoMap 1.9.7's arithmetic, operation by operation: a map equals OctoMap's only if every
/// rounding does. Compile with -ffp-contract=off.
namespace pipewright::key_math {

constexpr int kReach = 1 << 15;  ///< keys are 16 bits: |index| is below this

/// floor without a library call; |x| < 2^31.
inline int Floor(double x) {
  const int i = static_cast<int>(x);
  return i - (x < i ? 1 : 0);
}

/// OcTreeBaseImpl::coordToKeyChecked, less 32768. False: not finite, or beyond the keys.
inline bool VoxelOf(const Vector3f& p_W, double width_inv, VoxelIndex* v) {
  const double x = width_inv * static_cast<double>(p_W.x());
  const double y = width_inv * static_cast<double>(p_W.y());
  const double z = width_inv * static_cast<double>(p_W.z());
  const auto ok = [](double c) { return c >= -kReach && c < kReach; };
  if (!ok(x) || !ok(y) || !ok(z)) {
    return false;
  }
  *v = {Floor(x), Floor(y), Floor(z)};
  return true;
}

/// OcTreeBaseImpl::keyToCoord of one axis.
inline double Center(int index, double width_m) { return (index + 0.5) * width_m; }

/// octomath::Vector3::norm: the sum of squares in float, the root in double.
inline double Norm(const Vector3f& v) {
  return std::sqrt(static_cast<double>(v.x() * v.x() + v.y() * v.y() + v.z() * v.z()));
}

/// A vector divided by its length as a float.
inline Vector3f Divided(const Vector3f& v, float length) {
  return {v.x() / length, v.y() / length, v.z() / length};
}

}  // namespace pipewright::key_math
