// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "perception/primitives/track.h"

namespace pipewright {
namespace {

// Quantiles 0.999 of chi-square with 3 and 5 degrees of freedom.
constexpr double kGatePlane = 16.27;
constexpr double kGatePipe = 20.52;

template <int n>
struct Fused {
  Vec<n> x = Vec<n>::Zero();  ///< change of the track
  Mat<n, n> P = Mat<n, n>::Zero();
  double innovation2 = 0;
};

/// One Kalman update of a state 0 with covariance P by measurement z with covariance R. The
/// innovation is judged with the pose's error in it. (Joseph's form stays positive.)
template <int n>
Fused<n> Update(Mat<n, n> P, const Mat<n, n>& R, const Mat<n, n>& pose, const Vec<n>& z,
                double gate) {
  Fused<n> out;
  const Mat<n, n> total = P + R + pose;
  out.innovation2 = z.dot(Eigen::LDLT<Mat<n, n>>(total).solve(z));
  if (out.innovation2 > gate) {
    P += (out.innovation2 / gate - 1) * total;
  }
  const Mat<n, n> S = P + R;
  const Mat<n, n> K = Eigen::LDLT<Mat<n, n>>(S).solve(P).transpose();
  const Mat<n, n> rest = Mat<n, n>::Identity() - K;
  out.x = K * z;
  out.P = rest * P * rest.transpose() + K * R * K.transpose();
  out.P = (out.P + out.P.transpose()).eval() / 2;
  return out;
}

/// Coordinates x of PlaneTangent from a change of (n, d): the left inverse of G.
Mat<3, 4> PlaneCoordinates(const PlaneEstimate& plane) {
  Mat<3, 4> H = Mat<3, 4>::Zero();
  H.block<1, 3>(0, 0) = plane.e1_W.transpose();
  H.block<1, 3>(1, 0) = plane.e2_W.transpose();
  H.block<1, 3>(2, 0) = -plane.p_WCentroid.transpose();
  H(2, 3) = 1;
  return H;
}

/// The rectangle that holds both; the centroid moves to its middle.
void GrowExtent(PlaneEstimate& track, const PlaneEstimate& seen) {
  for (int k = 0; k < 4; ++k) {
    const double a = k % 2 == 0 ? seen.extent_lo_m[0] : seen.extent_hi_m[0];
    const double b = k / 2 == 0 ? seen.extent_lo_m[1] : seen.extent_hi_m[1];
    const Vector3d w = seen.p_WCentroid + a * seen.e1_W + b * seen.e2_W - track.p_WCentroid;
    const double along[2] = {track.e1_W.dot(w), track.e2_W.dot(w)};
    for (int i = 0; i < 2; ++i) {
      track.extent_lo_m[i] = std::min(track.extent_lo_m[i], along[i]);
      track.extent_hi_m[i] = std::max(track.extent_hi_m[i], along[i]);
    }
  }
}

/// After n has changed: axes across it, the centroid on the plane.
void Restore(PlaneEstimate& plane) {
  plane.n_W.normalize();
  plane.e1_W = (plane.e1_W - plane.n_W.dot(plane.e1_W) * plane.n_W).normalized();
  plane.e2_W = plane.n_W.cross(plane.e1_W);
  plane.p_WCentroid -= (plane.n_W.dot(plane.p_WCentroid) - plane.d_m) * plane.n_W;
}

}  // namespace

double Fuse(PlaneEstimate& track, const PlaneEstimate& seen, const PrimitiveConfig& config,
            const Vector3d& p_WS) {
  const Mat<3, 4> H = PlaneCoordinates(track);
  Vec<4> change;
  change << seen.n_W - track.n_W, seen.d_m - track.d_m;
  const Mat<3, 3> P = H * track.covariance * H.transpose();
  const Mat<3, 3> R = H * seen.covariance * H.transpose();
  const Mat<3, 3> pose = 2 * H * PoseCovariance(seen, p_WS, config) * H.transpose();
  const auto fused = Update<3>(P, R, pose, H * change, kGatePlane);
  const Vector3d& x = fused.x;
  const Vector3d tilt = x(0) * track.e1_W + x(1) * track.e2_W;
  track.n_W = (track.n_W + tilt).normalized();
  const Vector3d c = track.p_WCentroid;
  // n'c = d at the old plane; the new one passes at x3 from there.
  track.d_m = track.n_W.dot(c) + x(2);
  Restore(track);
  const Mat<4, 3> G = PlaneTangent(track);
  track.covariance = G * fused.P * G.transpose();
  GrowExtent(track, seen);
  return fused.innovation2;
}

double Fuse(PipeEstimate& track, const PipeEstimate& measured, const PrimitiveConfig& config,
            const Vector3d& p_WS) {
  PipeEstimate seen = measured;
  AlignAxis(seen, track.l_W);
  // Compare where the new part was seen: the track's p goes to the foot of its middle.
  const double middle_m = (seen.extent_lo_m + seen.extent_hi_m) / 2;
  SlideAlong(track, track.l_W.dot(seen.p_W + middle_m * seen.l_W - track.p_W));
  SlideAlong(seen, track.l_W.dot(track.p_W - seen.p_W) / track.l_W.dot(seen.l_W));
  const Mat<7, 5> G = PipeTangent(track);
  Vec<7> change;
  change << seen.p_W - track.p_W, seen.l_W - track.l_W, seen.radius_m - track.radius_m;
  const Mat<5, 5> P = G.transpose() * track.covariance * G;
  const Mat<5, 5> R = G.transpose() * seen.covariance * G;
  const Mat<5, 5> pose = 2 * G.transpose() * PoseCovariance(seen, p_WS, config) * G;
  const Vec<5> z = G.transpose() * change;
  const auto fused = Update<5>(P, R, pose, z, kGatePipe);
  const Vec<7> moved = G * fused.x;
  track.p_W += moved.head<3>();
  track.l_W = (track.l_W + moved.segment<3>(3)).normalized();
  track.radius_m += moved(6);
  const Mat<7, 5> after = PipeTangent(track);
  const Mat<5, 5> turn = after.transpose() * G;  // the basis of the tangent may have turned
  const Mat<5, 5> P_after = turn * fused.P * turn.transpose();
  track.covariance = after * P_after * after.transpose();
  track.extent_lo_m = std::min(track.extent_lo_m, seen.extent_lo_m);
  track.extent_hi_m = std::max(track.extent_hi_m, seen.extent_hi_m);
  SlideAlong(track, (track.extent_lo_m + track.extent_hi_m) / 2);
  return fused.innovation2;
}

}  // namespace pipewright
