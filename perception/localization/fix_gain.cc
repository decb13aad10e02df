// SPDX-License-Identifier: MIT
#include "perception/localization/fix_gain.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace pipewright {
namespace {

/// Of L's diagonal, to be definite and not to say anything: a standard deviation of 30 km.
constexpr double kNothing = 1e-9;

/// The covariance of a fix whose directions are turned by a small angle of this variance.
Mat<3, 3> OfTilt(const Mat<3, 3>& M, double tilt_rad2) {
  Mat<3, 3> turned = Mat<3, 3>::Zero();
  turned(0, 0) = M(1, 1);
  turned(1, 1) = M(0, 0);
  turned(0, 1) = turned(1, 0) = -M(0, 1);
  return tilt_rad2 * turned;
}

/// L = W - W (share I + W)⁻¹ W with W = Σ⁻¹, for an I that may be singular.
Mat<3, 3> Information(const PoseFix& fix, const Mat<3, 3>& M, const Vector3d& common,
                      const FixNoiseConfig& config) {
  const double of_place = config.sigma_m * config.sigma_m;
  const double of_heading = config.sigma_rad * config.sigma_rad;
  const Vector3d placed = (Variances(fix.placed) - common).cwiseMax(0);
  Mat<3, 3> shared = OfTilt(M, config.tilt_rad * config.tilt_rad);
  shared.diagonal() += Vector3d(of_place, of_place, of_heading) + placed;
  const Mat<3, 3> W = shared.inverse();
  const Mat<3, 3> sum = config.share * fix.information + W;
  const Mat<3, 3> inner = sum.inverse().lazyProduct(W);
  const Mat<3, 3> L = W - W.lazyProduct(inner);
  return (L + L.transpose()) / 2 + kNothing * Mat<3, 3>::Identity();
}

}  // namespace

FixGain GainOf(const Vector3d& pose, const Mat<3, 3>& M, const PoseFix& fix, const Vector3d& common,
               const FixNoiseConfig& config) {
  FixGain gain;
  gain.y = fix.pose - pose;
  gain.y.z() = std::remainder(gain.y.z(), 2 * std::numbers::pi);
  const Mat<3, 3> C = Information(fix, M, common, config).llt().matrixL();
  const Mat<3, 3> MC = M.lazyProduct(C);
  const Mat<3, 3> A = Mat<3, 3>::Identity() + C.transpose().lazyProduct(MC);
  const Mat<3, 3> AC = A.inverse().lazyProduct(C.transpose());
  gain.S_inverse = C.lazyProduct(AC);
  gain.within_gate = gain.y.dot(gain.S_inverse.lazyProduct(gain.y)) <= config.gate;
  return gain;
}

}  // namespace pipewright
