// SPDX-License-Identifier: MIT
#pragma once

#include "perception/scene.h"
#include "platform/core/frames.h"

namespace pipewright {

/// Distance of a robot point T to a primitive, with what its derivatives are made of.
struct PointDistance {
  double d_m = 0;  ///< signed for planes; else ≥ 0
  /// ∂d/∂p_WT: d' = gradient' J_t u. Unit length, or zero where the distance has no derivative.
  Vector3d gradient_W = Vector3d::Zero();
};

/// d = n't − d_π, of the plane without end. [CFNBV] (8)
PointDistance PointToPlane(const Vector3d& p_WT, const PlaneEstimate& plane);

/// Distance to the segment of the pipe's axis that was seen, `inflation` longer at either end: the
/// foot is p + s l, s = clamp(l't', lo − inflation, hi + inflation) with t' = t − p.
///
/// One convex set for all points: d is continuous, so is its gradient off the axis, and d is never
/// more than the distance to what was seen. A row on it therefore holds motion across the axis and
/// motion along it towards the end alike, and no row appears at a distance that is already too
/// small. (An end that acts at the seen extent and a line that acts beyond it do not fit together:
/// d falls from √(ρ² + inflation²) to ρ where they meet, and a point on the axis is let in.)
struct AxisDistance {
  PointDistance to_axis;
  double s_m = 0;       ///< where on the axis the nearest point is
  bool at_end = false;  ///< the nearest point is an end, fixed at s
};
AxisDistance PointToPipeAxis(const Vector3d& p_WT, const PipeEstimate& pipe, double inflation_m);

/// d = |t − p|
PointDistance PointToPoint(const Vector3d& p_WT, const Vector3d& p_WQ);

/// Nearest points of two segments.
struct SegmentPair {
  double d_m = 0;
  double s = 0;  ///< nearest point of the first: a0 + s (a1 − a0), s in [0, 1]
  double t = 0;
  Vector3d direction_W = Vector3d::Zero();  ///< from the second to the first; zero when they meet
};

/// [RTCD] Ericson: Real-Time Collision Detection, 2005, 5.1.9. Segments may be points.
SegmentPair SegmentToSegment(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                             const Vector3d& b1);

/// Nearest points of a segment and a box.
struct BoxPair {
  Vector3d p_WSegment = Vector3d::Zero();
  Vector3d p_WBox = Vector3d::Zero();  ///< equal to p_WSegment when they meet
};

/// @param X_WG    pose of the box's centre
/// @param half_m  its half edges
/// The squared distance is convex along the segment and its slope piecewise linear, with corners
/// where the line crosses a face: the zero lies between two of them.
BoxPair SegmentToBox(const Vector3d& a, const Vector3d& b, const Isometry3d& X_WG,
                     const Vector3d& half_m);

}  // namespace pipewright
