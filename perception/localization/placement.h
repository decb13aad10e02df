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

/// A base that finds itself among surfaces comes to know where it is among them, however often it
/// looks, and not where they are: not surer after a fix than they are placed, unless it was before.
inline double NotSurerThan(double surfaces, double before, double after) {
  return std::max(after, std::min(before, surfaces));
}

inline Placement NotSurerThan(const Placement& surfaces, const Placement& before,
                              const Placement& after) {
  return {NotSurerThan(surfaces.m2, before.m2, after.m2),
          NotSurerThan(surfaces.rad2, before.rad2, after.rad2)};
}

}  // namespace pipewright
