// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <cmath>

#include "platform/core/frames.h"

namespace pipewright {

/// N⁻¹, or nothing where N is not safely positive definite.
template <int n>
bool Invert(const Mat<n, n>& N, Mat<n, n>& inverse) {
  const Vec<n> scale = N.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Mat<n, n> scaled = scale.asDiagonal() * N * scale.asDiagonal();
  const Eigen::LDLT<Mat<n, n>> ldlt(scaled);
  if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 1e-9)) {
    return false;
  }
  inverse = scale.asDiagonal() * ldlt.solve(Mat<n, n>::Identity()) * scale.asDiagonal();
  return inverse.allFinite();
}

/// Factor of a covariance: chi2 per degree of freedom where chance does not explain it.
inline double Widening(double chi2, double freedoms) {
  constexpr double kChanceSigmas = 3;
  return chi2 > 1 + kChanceSigmas * std::sqrt(2 / freedoms) ? chi2 : 1;
}

}  // namespace pipewright
