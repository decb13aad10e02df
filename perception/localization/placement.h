// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "platform/core/frames.h"

namespace pipewright {

/// How unsure the base was of itself when it saw something: the variances of its place, each way,
/// and of its heading. What it then put on a map is off by the same error, as one body.
struct Placement {
  double m2 = 0;
  double rad2 = 0;

  double at_1m() const { return m2 + rad2; }
};

/// Of a pose (x, y, phi) with this covariance.
inline Placement PlacementOf(const Mat<3, 3>& covariance) {
  return {(covariance(0, 0) + covariance(1, 1)) / 2, covariance(2, 2)};
}

/// Of (x, y, phi).
inline Vector3d Variances(const Placement& placed) { return {placed.m2, placed.m2, placed.rad2}; }

/// Takes from the covariance P of a state that begins with (x, y, phi) the variances `more` that
/// are kept beside it from now on, as far as it has them, or gives them back where they are
/// negative. With a_k the share of P_kk that stays, 1 where nothing is taken,
///
///   P_ij <- min(a_i, a_j) P_ij
///
/// which is a covariance again, as the kernel min is; and no cov(i, j)/var(j) grows by it, so that
/// a fix of j moves i by no more than before.
template <int N>
void TakeOut(const Vector3d& more, Mat<N, N>& P) {
  Eigen::Matrix<double, N, 1> stays = Eigen::Matrix<double, N, 1>::Ones();
  for (int k = 0; k < 3; ++k) {
    if (more(k) > 0) {
      stays(k) = more(k) < P(k, k) ? 1 - more(k) / P(k, k) : 0;
    }
  }
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      P(i, j) *= std::min(stays(i), stays(j));
    }
  }
  P.diagonal().template head<3>() += (-more).cwiseMax(0);
}

/// A base that finds itself among surfaces comes to know where it is among them, however often it
/// looks, and not where they are. Its error is a random walk, and they took theirs from it: the
/// lesser of both variances is common to both, and no fix among them tells of it.
///
/// @param P       covariance of a state that begins with (x, y, phi), less `common`
/// @param common  variances of (x, y, phi)
/// @returns the variances common to the base and to surfaces that are placed so
template <int N>
Vector3d CommonWith(const Placement& surfaces, const Vector3d& common, Mat<N, N>& P) {
  const Vector3d theirs = Variances(surfaces);
  Vector3d both = theirs.cwiseMin(P.diagonal().template head<3>() + common);
  TakeOut(both - common, P);
  return both;
}

}  // namespace pipewright
