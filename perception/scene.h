// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "platform/core/fixed_vector.h"
#include "platform/core/frames.h"
#include "platform/core/time.h"

namespace pipewright {

/// A plane n'x = d in W, |n| = 1, n towards the side it was seen from, with the part of it that was
/// seen: a rectangle about the centroid.
struct PlaneEstimate {
  std::uint32_t id = 0;
  Vector3d n_W = Vector3d::UnitZ();
  double d_m = 0;
  /// Of (n, d) in W: 4x4, rank 3 (n moves in its tangent plane only).
  Mat<4, 4> covariance = Mat<4, 4>::Zero();
  Vector3d p_WCentroid = Vector3d::Zero();
  Vector3d e1_W = Vector3d::UnitX();  ///< in-plane axes of the rectangle; e1 x e2 = n
  Vector3d e2_W = Vector3d::UnitY();
  double extent_lo_m[2] = {0, 0};  ///< along e1, e2 from the centroid
  double extent_hi_m[2] = {0, 0};
  int frames_seen = 0;
  Time last_seen{};
};

/// A cylinder: axis through p along l (|l| = 1), radius r, seen between two points of the axis.
struct PipeEstimate {
  std::uint32_t id = 0;
  Vector3d p_W =
      Vector3d::Zero();  ///< the axis point that is nearest to the centroid of its support
  Vector3d l_W = Vector3d::UnitX();
  double radius_m = 0;
  /// Of (p, l, r) in W: 7x7, rank 5 (p moves across the axis, l in its tangent plane).
  Mat<7, 7> covariance = Mat<7, 7>::Zero();
  double extent_lo_m = 0;  ///< along l from p
  double extent_hi_m = 0;
  int frames_seen = 0;
  Time last_seen{};
};

/// The geometric primitives that perception holds true now.
struct Scene {
  static constexpr int kMaxPlanes = 16;
  static constexpr int kMaxPipes = 16;

  Time stamp{};
  FixedVector<PlaneEstimate, kMaxPlanes> planes;
  FixedVector<PipeEstimate, kMaxPipes> pipes;
};

}  // namespace pipewright
