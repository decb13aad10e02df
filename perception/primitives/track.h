// SPDX-License-Identifier: MIT
#pragma once

#include "perception/primitives/config.h"
#include "perception/primitives/detector.h"
#include "perception/scene.h"

namespace pipewright {

/// What is known of how long and how well a primitive has been seen.
struct TrackLife {
  bool confirmed = false;
  int age_frames = 0;
  int contradictions = 0;            ///< frames that saw through it, less those that saw it
  Vector3d p_WS = Vector3d::Zero();  ///< the camera when it was last seen
};

/// A primitive under a Kalman filter. `estimate.covariance` is that of the filter: readings' noise
/// and drift, without the error of the pose that all frames share.
struct PlaneTrack {
  PlaneEstimate estimate;
  TrackLife life;
};
struct PipeTrack {
  PipeEstimate estimate;
  TrackLife life;
};

/// The filter's coordinates: small changes of a primitive that are free.
///   plane: (tilt along e1, tilt along e2, offset at the centroid)
///     ∂n = x1 e1 + x2 e2,  ∂d = c'∂n + x3
///   pipe, with (e1, e2, l) orthonormal: (p across, p across, tilt, tilt, r)
///     ∂p = x1 e1 + x2 e2,  ∂l = x3 e1 + x4 e2,  ∂r = x5
Mat<4, 3> PlaneTangent(const PlaneEstimate& plane);
Mat<7, 5> PipeTangent(const PipeEstimate& pipe);

/// A detection as an estimate in W. Covariances move with the frame:
///   n_W = R n,  d_W = d + n_W'p_WS,  so  ∂d_W = ∂d + p_WS'R ∂n;   ∂p_W = R ∂p,  ∂l_W = R ∂l
PlaneEstimate ToWorld(const DetectedPlane& plane, const Isometry3d& X_WS);
PipeEstimate ToWorld(const DetectedPipe& pipe, const Isometry3d& X_WS);

/// The way back, without covariance: a hint.
PlaneFit ToSensor(const PlaneEstimate& plane, const Isometry3d& X_WS);
CylinderFit ToSensor(const PipeEstimate& pipe, const Isometry3d& X_WS);

/// Moves p along the axis by s; extents and covariance follow (∂p' = ∂p + s ∂l).
void SlideAlong(PipeEstimate& pipe, double s_m);

/// How a detection lies to a track.
struct Fit {
  double angle_rad = 0;
  double offset_m = 0;  ///< of one's middle from the other, the smaller of both ways
  double radius_m = 0;  ///< difference
  double gap_m = 0;     ///< between the parts seen; negative: they overlap
};
Fit Compare(const PlaneEstimate& a, const PlaneEstimate& b);
Fit Compare(const PipeEstimate& a, const PipeEstimate& b);

/// Walks the covariance by a frame's worth: tilt and offset at the centroid.
void Drift(PlaneEstimate& plane, double sigma_rad, double sigma_m);
void Drift(PipeEstimate& pipe, double sigma_rad, double sigma_m);

/// Fuses a measurement of the same primitive in; extents grow. Returns the innovation squared over
/// its covariance (3 or 5 degrees of freedom), the error of the pose included. One that is too
/// large to be chance widens the filter first: then pose or filter were too sure.
double Fuse(PlaneEstimate& track, const PlaneEstimate& seen, const PrimitiveConfig& config,
            const Vector3d& p_WS);
double Fuse(PipeEstimate& track, const PipeEstimate& seen, const PrimitiveConfig& config,
            const Vector3d& p_WS);

/// Covariance that an error of the camera's pose at p_WS (rotation σθ, translation σp, all axes)
/// gives the primitive.
Mat<4, 4> PoseCovariance(const PlaneEstimate& plane, const Vector3d& p_WS,
                         const PrimitiveConfig& config);
Mat<7, 7> PoseCovariance(const PipeEstimate& pipe, const Vector3d& p_WS,
                         const PrimitiveConfig& config);

/// Signed so that both point the same way.
void AlignAxis(PipeEstimate& pipe, const Vector3d& l_W);

}  // namespace pipewright
