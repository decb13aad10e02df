// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

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

/// A base that finds itself among surfaces comes to know where it is among them, however often it
/// looks, and not where they are. Its error is a random walk, and they took theirs from it: the
/// lesser of both variances is common to both, and no fix among them tells of it.
///
/// @param P       covariance of a state that begins with (x, y, phi), less `common`: given anew by
///                scaling rows and columns where more of it is common now
/// @param common  variances of (x, y, phi)
/// @returns the variances common to the base and to surfaces that are placed so
template <int N>
Vector3d CommonWith(const Placement& surfaces, const Vector3d& common, Mat<N, N>& P) {
  const Vector3d theirs = Variances(surfaces);
  const Vector3d both = theirs.cwiseMin(P.diagonal().template head<3>() + common);
  for (int k = 0; k < 3; ++k) {
    const double more = both(k) - common(k);
    if (more <= 0) {
      P(k, k) -= more;
      continue;
    }
    const double scale = std::sqrt(std::max(0.0, P(k, k) - more) / P(k, k));
    P.row(k) *= scale;
    P.col(k) *= scale;
  }
  return both;
}

}  // namespace pipewright
