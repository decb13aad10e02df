// SPDX-License-Identifier: MIT
#include "perception/primitives/soundness.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace pipewright {
namespace {

constexpr double kPart = 1e-9;  // of the trace
constexpr double kLength = 1e-6;

template <int n>
bool SoundCovariance(const Mat<n, n>& covariance) {
  const double trace = covariance.trace();
  if (!covariance.allFinite() || !(trace > 0) ||
      (covariance - covariance.transpose()).cwiseAbs().maxCoeff() > kPart * trace) {
    return false;
  }
  const Eigen::SelfAdjointEigenSolver<Mat<n, n>> of(covariance / trace, Eigen::EigenvaluesOnly);
  return of.info() == Eigen::Success && of.eigenvalues()(0) >= -kPart;
}

bool Direction(const Vector3d& v) { return std::abs(v.norm() - 1) < kLength; }

}  // namespace

bool Sound(const PlaneEstimate& plane) {
  for (const int i : {0, 1}) {
    if (!(std::isfinite(plane.extent_lo_m[i]) && std::isfinite(plane.extent_hi_m[i]) &&
          plane.extent_lo_m[i] <= plane.extent_hi_m[i])) {
      return false;
    }
  }
  return Direction(plane.n_W) && Direction(plane.e1_W) && Direction(plane.e2_W) &&
         plane.p_WCentroid.allFinite() && std::isfinite(plane.d_m) &&
         SoundCovariance(plane.covariance);
}

bool Sound(const PipeEstimate& pipe) {
  return Direction(pipe.l_W) && pipe.p_W.allFinite() && std::isfinite(pipe.radius_m) &&
         pipe.radius_m > 0 && std::isfinite(pipe.extent_lo_m) && std::isfinite(pipe.extent_hi_m) &&
         pipe.extent_lo_m <= pipe.extent_hi_m && SoundCovariance(pipe.covariance);
}

}  // namespace pipewright
