// SPDX-License-Identifier: MIT
#include "perception/primitives/evidence.h"

#include <cmath>
#include <optional>

#include "perception/primitives/track.h"

namespace pipewright {
namespace {

constexpr double kTolerance_m = 0.03;
constexpr double kCore = 0.6;       // of a pipe's radius: its rim may be missed by a little
constexpr double kMinFacing = 0.2;  // a plane seen more edge-on than this cosine says nothing

template <typename DepthOf>
Evidence Look(const DepthView& view, const DepthNoise& noise, int step, const DepthOf& depth_of) {
  Evidence evidence;
  for (int row = 0; row < view.height(); row += step) {
    for (int column = 0; column < view.width(); column += step) {
      const int i = row * view.width() + column;
      if (!view.seen(i)) {
        continue;
      }
      const std::optional<double> z = depth_of(Vector3d(view.x(i), view.y(i), 1));
      if (!z) {
        continue;
      }
      const double tolerance_m = kTolerance_m + 4 * *z * *z * noise.SigmaInverse(1 / *z);
      const double off_m = 1 / static_cast<double>(view.inverse_z(i)) - *z;
      evidence.through += off_m > tolerance_m;
      evidence.hidden += off_m < -tolerance_m;
      evidence.agree += std::abs(off_m) <= tolerance_m;
    }
  }
  return evidence;
}

}  // namespace

Evidence LookAt(const DepthView& view, const PlaneEstimate& plane, const DepthNoise& noise,
                int step) {
  const PlaneFit fit = ToSensor(plane, view.X_WS());
  const Matrix3d R_SW = view.X_WS().linear().transpose();
  const Vector3d e1 = R_SW * plane.e1_W;
  const Vector3d e2 = R_SW * plane.e2_W;
  const Vector3d c = view.X_WS().inverse() * plane.p_WCentroid;
  if (fit.d_m >= 0) {
    return {};  // from behind
  }
  return Look(view, noise, step, [&](const Vector3d& ray) -> std::optional<double> {
    const double facing = -fit.n_S.dot(ray);
    if (facing < kMinFacing * std::sqrt(ray.squaredNorm())) {
      return std::nullopt;
    }
    const double z = -fit.d_m / facing;
    const Vector3d w = z * ray - c;
    const double a = e1.dot(w);
    const double b = e2.dot(w);
    const bool within = a >= plane.extent_lo_m[0] && a <= plane.extent_hi_m[0] &&
                        b >= plane.extent_lo_m[1] && b <= plane.extent_hi_m[1];
    return within ? std::optional<double>(z) : std::nullopt;
  });
}

Evidence LookAt(const DepthView& view, const PipeEstimate& pipe, const DepthNoise& noise,
                int step) {
  CylinderFit core = ToSensor(pipe, view.X_WS());
  core.radius_m = kCore * pipe.radius_m;
  const double half_m = (pipe.extent_hi_m - pipe.extent_lo_m) / 2;
  return Look(view, noise, step,
              [&](const Vector3d& ray) { return DepthOfPipe(ray, core, -half_m, half_m); });
}

}  // namespace pipewright
