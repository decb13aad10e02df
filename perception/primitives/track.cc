// SPDX-License-Identifier: MIT
#include "perception/primitives/track.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

Matrix3d Cross(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

/// The four corners of a plane's rectangle.
Vector3d Corner(const PlaneEstimate& plane, int k) {
  const double a = k % 2 == 0 ? plane.extent_lo_m[0] : plane.extent_hi_m[0];
  const double b = k / 2 == 0 ? plane.extent_lo_m[1] : plane.extent_hi_m[1];
  return plane.p_WCentroid + a * plane.e1_W + b * plane.e2_W;
}

double Angle(double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); }

}  // namespace

Mat<4, 3> PlaneTangent(const PlaneEstimate& plane) {
  Mat<4, 3> G = Mat<4, 3>::Zero();
  G.block<3, 1>(0, 0) = plane.e1_W;
  G.block<3, 1>(0, 1) = plane.e2_W;
  G(3, 0) = plane.p_WCentroid.dot(plane.e1_W);
  G(3, 1) = plane.p_WCentroid.dot(plane.e2_W);
  G(3, 2) = 1;
  return G;
}

Mat<7, 5> PipeTangent(const PipeEstimate& pipe) {
  const Vector3d e1 = pipe.l_W.unitOrthogonal();
  const Vector3d e2 = pipe.l_W.cross(e1);
  Mat<7, 5> G = Mat<7, 5>::Zero();
  G.block<3, 1>(0, 0) = G.block<3, 1>(3, 2) = e1;
  G.block<3, 1>(0, 1) = G.block<3, 1>(3, 3) = e2;
  G(6, 4) = 1;
  return G;
}

PlaneEstimate ToWorld(const DetectedPlane& plane, const Isometry3d& X_WS) {
  const Matrix3d R_WS = X_WS.linear();
  const Vector3d p_WS = X_WS.translation();
  PlaneEstimate out;
  out.n_W = R_WS * plane.fit.n_S;
  out.d_m = plane.fit.d_m + out.n_W.dot(p_WS);
  Mat<4, 4> T = Mat<4, 4>::Zero();
  T.topLeftCorner<3, 3>() = R_WS;
  T.block<1, 3>(3, 0) = p_WS.transpose() * R_WS;
  T(3, 3) = 1;
  out.covariance = T * plane.fit.covariance * T.transpose();
  out.p_WCentroid = X_WS * plane.p_SCentroid;
  out.e1_W = R_WS * plane.e1_S;
  out.e2_W = R_WS * plane.e2_S;
  for (int a = 0; a < 2; ++a) {
    out.extent_lo_m[a] = plane.lo_m[a];
    out.extent_hi_m[a] = plane.hi_m[a];
  }
  return out;
}

PipeEstimate ToWorld(const DetectedPipe& pipe, const Isometry3d& X_WS) {
  PipeEstimate out;
  out.p_W = X_WS * pipe.fit.p_S;
  out.l_W = X_WS.linear() * pipe.fit.l_S;
  out.radius_m = pipe.fit.radius_m;
  Mat<7, 7> T = Mat<7, 7>::Identity();
  T.block<3, 3>(0, 0) = T.block<3, 3>(3, 3) = X_WS.linear();
  out.covariance = T * pipe.fit.covariance * T.transpose();
  out.extent_lo_m = pipe.lo_m;
  out.extent_hi_m = pipe.hi_m;
  return out;
}

PlaneFit ToSensor(const PlaneEstimate& plane, const Isometry3d& X_WS) {
  PlaneFit fit;
  fit.n_S = X_WS.linear().transpose() * plane.n_W;
  fit.d_m = plane.d_m - plane.n_W.dot(X_WS.translation());
  return fit;
}

CylinderFit ToSensor(const PipeEstimate& pipe, const Isometry3d& X_WS) {
  CylinderFit fit;
  const double middle_m = (pipe.extent_lo_m + pipe.extent_hi_m) / 2;
  fit.p_S = X_WS.inverse() * Vector3d(pipe.p_W + middle_m * pipe.l_W);
  fit.l_S = X_WS.linear().transpose() * pipe.l_W;
  fit.radius_m = pipe.radius_m;
  return fit;
}

void SlideAlong(PipeEstimate& pipe, double s_m) {
  pipe.p_W += s_m * pipe.l_W;
  pipe.extent_lo_m -= s_m;
  pipe.extent_hi_m -= s_m;
  Mat<7, 7> T = Mat<7, 7>::Identity();
  T.block<3, 3>(0, 3) = s_m * Matrix3d::Identity();
  pipe.covariance = T * pipe.covariance * T.transpose();
}

void AlignAxis(PipeEstimate& pipe, const Vector3d& l_W) {
  if (pipe.l_W.dot(l_W) >= 0) {
    return;
  }
  pipe.l_W = -pipe.l_W;
  const double lo_m = pipe.extent_lo_m;
  pipe.extent_lo_m = -pipe.extent_hi_m;
  pipe.extent_hi_m = -lo_m;
  pipe.covariance.block<3, 7>(3, 0) *= -1;
  pipe.covariance.block<7, 3>(0, 3) *= -1;
}

Fit Compare(const PlaneEstimate& a, const PlaneEstimate& b) {
  Fit fit;
  fit.angle_rad = Angle(a.n_W.dot(b.n_W));
  fit.offset_m = std::min(std::abs(a.n_W.dot(b.p_WCentroid) - a.d_m),
                          std::abs(b.n_W.dot(a.p_WCentroid) - b.d_m));
  double lo[2] = {1e9, 1e9};
  double hi[2] = {-1e9, -1e9};
  for (int k = 0; k < 4; ++k) {
    const Vector3d w = Corner(b, k) - a.p_WCentroid;
    const double along[2] = {a.e1_W.dot(w), a.e2_W.dot(w)};
    for (int i = 0; i < 2; ++i) {
      lo[i] = std::min(lo[i], along[i]);
      hi[i] = std::max(hi[i], along[i]);
    }
  }
  fit.gap_m = -1e9;
  for (int i = 0; i < 2; ++i) {
    fit.gap_m = std::max({fit.gap_m, lo[i] - a.extent_hi_m[i], a.extent_lo_m[i] - hi[i]});
  }
  return fit;
}

Fit Compare(const PipeEstimate& a, const PipeEstimate& b) {
  Fit fit;
  fit.angle_rad = Angle(std::abs(a.l_W.dot(b.l_W)));
  const auto away = [](const PipeEstimate& from, const PipeEstimate& to) {
    const double middle_m = (to.extent_lo_m + to.extent_hi_m) / 2;
    const Vector3d w = to.p_W + middle_m * to.l_W - from.p_W;
    return std::sqrt((w - from.l_W.dot(w) * from.l_W).squaredNorm());
  };
  fit.offset_m = std::min(away(a, b), away(b, a));
  fit.radius_m = std::abs(a.radius_m - b.radius_m);
  const double s0 = a.l_W.dot(b.p_W + b.extent_lo_m * b.l_W - a.p_W);
  const double s1 = a.l_W.dot(b.p_W + b.extent_hi_m * b.l_W - a.p_W);
  fit.gap_m = std::max(std::min(s0, s1) - a.extent_hi_m, a.extent_lo_m - std::max(s0, s1));
  return fit;
}

void Drift(PlaneEstimate& plane, double sigma_rad, double sigma_m) {
  const Mat<4, 3> G = PlaneTangent(plane);
  const Vec<3> q{sigma_rad * sigma_rad, sigma_rad * sigma_rad, sigma_m * sigma_m};
  plane.covariance += G * q.asDiagonal() * G.transpose();
}

void Drift(PipeEstimate& pipe, double sigma_rad, double sigma_m) {
  // Across the middle of what was seen, not at p, which may lie elsewhere on the axis.
  const double middle_m = (pipe.extent_lo_m + pipe.extent_hi_m) / 2;
  SlideAlong(pipe, middle_m);
  const Mat<7, 5> G = PipeTangent(pipe);
  Vec<5> q;
  q << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad, sigma_rad * sigma_rad, 0;
  pipe.covariance += G * q.asDiagonal() * G.transpose();
  SlideAlong(pipe, -middle_m);
}

Mat<4, 4> PoseCovariance(const PlaneEstimate& plane, const Vector3d& p_WS,
                         const PrimitiveConfig& config) {
  // ∂n = θ × n,  ∂d = p_WS'∂n + n'∂p_WS
  Mat<4, 6> J = Mat<4, 6>::Zero();
  const Matrix3d turn = -Cross(plane.n_W);
  J.topLeftCorner<3, 3>() = config.pose_sigma_rad * turn;
  J.block<1, 3>(3, 0) = config.pose_sigma_rad * p_WS.transpose() * turn;
  J.block<1, 3>(3, 3) = config.pose_sigma_m * plane.n_W.transpose();
  return J.lazyProduct(J.transpose());
}

Mat<7, 7> PoseCovariance(const PipeEstimate& pipe, const Vector3d& p_WS,
                         const PrimitiveConfig& config) {
  // ∂l = θ × l,  ∂p = (I − ll')(θ × (p − p_WS) + ∂p_WS)
  const Matrix3d across = Matrix3d::Identity() - pipe.l_W * pipe.l_W.transpose();
  Mat<7, 6> J = Mat<7, 6>::Zero();
  J.block<3, 3>(0, 0) = -config.pose_sigma_rad * across * Cross(pipe.p_W - p_WS);
  J.block<3, 3>(0, 3) = config.pose_sigma_m * across;
  J.block<3, 3>(3, 0) = -config.pose_sigma_rad * Cross(pipe.l_W);
  Mat<7, 7> covariance = J.lazyProduct(J.transpose());
  covariance(6, 6) += config.radius_sigma_m * config.radius_sigma_m;
  return covariance;
}

}  // namespace pipewright
