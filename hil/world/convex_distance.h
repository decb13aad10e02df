// SPDX-License-Identifier: MIT
#pragma once

#include "hil/world/shape.h"

namespace pipewright::hil {

/// Distance of two convex shapes A and B [m], by the algorithm of Gilbert, Johnson and Keerthi (A
/// fast procedure for computing the distance between complex objects in three-dimensional space,
/// 1988).
///
/// Every iteration bounds the distance from both sides, |v| from above and v'w/|v| from below, and
/// the search ends when they are within 1e-8 m: the error is bounded whatever the shapes, also for
/// the curved sides of cylinders. About 1 to 3 microseconds; at most 256 iterations.
///
/// @param stop_above_m  once the distance is known to be greater, the search ends and returns a
/// lower
///                      bound that is greater than this
/// @returns 0 when they touch or overlap
double ConvexDistance(const Shape& a, const Isometry3d& X_WA, const Shape& b,
                      const Isometry3d& X_WB, double stop_above_m = 1e9);

}  // namespace pipewright::hil
