// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "perception/scene.h"

namespace pipewright {

/// Distance of a point to a plane's slab: the seen rectangle, `inflation` wider on all sides, and
/// from there `behind` deep into what it is the surface of.
///
/// One convex body for all points: before its face d is that to the plane, beyond its border that
/// to the border, and behind it that to its back, so that d and, outside, its gradient are
/// continuous along every way round it. (A plane that acts on what is over its rectangle alone
/// lets a point come beside it to d = 0, and then asks for d_safe at once: what has gone round a
/// wall's end is wedged there.)
///
/// Inside, which a point enters only when the estimate jumps, −d is the depth below the nearest of
/// the face and the four sides. Not of the back: nothing is let through.
struct SlabDistance {
  double d_m = 0;                          ///< negative inside
  Vector3d away_P = Vector3d::UnitZ();     ///< ∂d/∂t along P's axes e1, e2, n; unit length
  Vector3d gradient_W = Vector3d::Zero();  ///< the same in W

  bool on_face() const { return away_P.z() == 1; }
};

inline SlabDistance PointToSlab(const Vector3d& p_WT, const PlaneEstimate& plane,
                                double inflation_m, double behind_m) {
  constexpr double kNoDirection_m = 1e-9;
  const Vector3d p_CT_W = p_WT - plane.p_WCentroid;
  const Vector3d t{plane.e1_W.dot(p_CT_W), plane.e2_W.dot(p_CT_W), plane.n_W.dot(p_WT) - plane.d_m};
  const Vector3d lo{plane.extent_lo_m[0] - inflation_m, plane.extent_lo_m[1] - inflation_m,
                    -behind_m};
  const Vector3d hi{plane.extent_hi_m[0] + inflation_m, plane.extent_hi_m[1] + inflation_m, 0};
  const Vector3d off = t - t.cwiseMax(lo).cwiseMin(hi);
  const double off_m = std::sqrt(off.squaredNorm());
  SlabDistance distance;
  distance.d_m = t.z();
  if (off_m > kNoDirection_m && off_m != off.z()) {
    distance.d_m = off_m;
    distance.away_P = off / off_m;
  } else if (off_m <= kNoDirection_m) {
    for (int i = 0; i < 2; ++i) {
      for (const double side : {-1.0, 1.0}) {
        const double past_m = side < 0 ? lo(i) - t(i) : t(i) - hi(i);
        if (past_m > distance.d_m) {
          distance.d_m = past_m;
          distance.away_P = side * Vector3d::Unit(i);
        }
      }
    }
  }
  distance.gradient_W = distance.away_P.x() * plane.e1_W + distance.away_P.y() * plane.e2_W +
                        distance.away_P.z() * plane.n_W;
  return distance;
}

}  // namespace pipewright
