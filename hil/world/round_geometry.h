// SPDX-License-Identifier: MIT
#pragma once

#include "hil/world/shape.h"

struct RTCDeviceTy;
struct RTCGeometryTy;

namespace pipewright::hil {

/// A cylinder or a sphere for Embree, as a user geometry: hits are roots of its own equation in
/// double precision, not of facets. (Embree's cone curves were up to 0.1 m off.)
struct RoundShape {
  Shape shape;
  Isometry3d X_WG = Isometry3d::Identity();
};

/// A geometry that refers to `round`, which must outlive it. Committed; the caller releases it.
///
/// A cylinder is cut into slices of a quarter metre, each with a box of its own, so that a long
/// slanted pipe is not hidden in one large box.
RTCGeometryTy* NewRoundGeometry(RTCDeviceTy* device, const RoundShape* round);

/// Where a ray o + t d, t_min < t < t_max, first meets the part of the shape that lies within
/// [slice_lo_m, slice_hi_m] of its axis, all in G. False: nowhere. Sets t and the outward normal.
bool IntersectRound(const Shape& shape, const Vector3d& o_G, const Vector3d& d_G, double slice_lo_m,
                    double slice_hi_m, double t_min, double t_max, double& t, Vector3d& n_G);

}  // namespace pipewright::hil
