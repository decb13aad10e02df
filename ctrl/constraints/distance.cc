// SPDX-License-Identifier: MIT
#include "ctrl/constraints/distance.h"

#include <algorithm>
#include <cmath>

namespace pipewright {

PointDistance PointToPlane(const Vector3d& p_WT, const PlaneEstimate& plane) {
  return {.d_m = plane.n_W.dot(p_WT) - plane.d_m, .gradient_W = plane.n_W};
}

AxisDistance PointToPipeAxis(const Vector3d& p_WT, const PipeEstimate& pipe, double inflation_m) {
  const Vector3d w = p_WT - pipe.p_W;
  const double foot = pipe.l_W.dot(w);
  const double s = std::clamp(foot, pipe.extent_lo_m - inflation_m, pipe.extent_hi_m + inflation_m);
  return {.to_axis = PointToPoint(p_WT, pipe.p_W + s * pipe.l_W), .s_m = s, .at_end = s != foot};
}

PointDistance PointToPoint(const Vector3d& p_WT, const Vector3d& p_WQ) {
  const Vector3d p_QT_W = p_WT - p_WQ;
  const double d = std::sqrt(p_QT_W.squaredNorm());
  constexpr double kNoDirection_m = 1e-9;
  return {.d_m = d,
          .gradient_W = d > kNoDirection_m ? Vector3d(p_QT_W / d) : Vector3d(Vector3d::Zero())};
}

SegmentPair SegmentToSegment(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                             const Vector3d& b1) {
  constexpr double kPoint_m2 = 1e-18;
  const Vector3d d1 = a1 - a0;
  const Vector3d d2 = b1 - b0;
  const Vector3d r = a0 - b0;
  const double a = d1.squaredNorm();
  const double e = d2.squaredNorm();
  const double f = d2.dot(r);
  double s = 0;
  double t = 0;
  if (a <= kPoint_m2) {
    t = e <= kPoint_m2 ? 0 : std::clamp(f / e, 0.0, 1.0);
  } else if (const double c = d1.dot(r); e <= kPoint_m2) {
    s = std::clamp(-c / a, 0.0, 1.0);
  } else {
    const double b = d1.dot(d2);
    const double denominator = a * e - b * b;
    s = denominator > 1e-12 * a * e ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
    t = (b * s + f) / e;
    if (t < 0 || t > 1) {
      t = t < 0 ? 0.0 : 1.0;
      s = std::clamp((b * t - c) / a, 0.0, 1.0);
    }
  }
  const PointDistance nearest = PointToPoint(a0 + s * d1, b0 + t * d2);
  return {.d_m = nearest.d_m, .s = s, .t = t, .direction_W = nearest.gradient_W};
}

BoxPair SegmentToBox(const Vector3d& a, const Vector3d& b, const Isometry3d& X_WG,
                     const Vector3d& half_m) {
  const Vector3d a_G = X_WG.linear().transpose() * (a - X_WG.translation());
  const Vector3d step_G = X_WG.linear().transpose() * (b - a);
  const auto in_box = [&](double s) -> Vector3d {
    return (a_G + s * step_G).cwiseMax(-half_m).cwiseMin(half_m);
  };
  const auto slope = [&](double s) { return (a_G + s * step_G - in_box(s)).dot(step_G); };
  double lo = 0;
  double hi = 1;
  double slope_lo = slope(lo);
  double slope_hi = slope(hi);
  for (int i = 0; i < 6; ++i) {  // the slope's corners: where the line crosses a face
    const double face = i < 3 ? -half_m(i) : half_m(i - 3);
    const double s = (face - a_G(i % 3)) / (step_G(i % 3) == 0 ? 1.0 : step_G(i % 3));
    if (s > lo && s < hi) {
      const double slope_s = slope(s);
      (slope_s < 0 ? lo : hi) = s;
      (slope_s < 0 ? slope_lo : slope_hi) = slope_s;
    }
  }
  double s = lo;
  if (slope_lo < 0) {
    s = slope_hi <= 0 ? hi : lo + (hi - lo) * slope_lo / (slope_lo - slope_hi);
  }
  return {.p_WSegment = a + s * (b - a), .p_WBox = X_WG * in_box(s)};
}

}  // namespace pipewright
