// SPDX-License-Identifier: MIT
#pragma once

#include "perception/localization/scan_registration.h"
#include "platform/core/usable.h"

namespace pipewright {

/// How far a fix is to be believed.
struct FixNoiseConfig {
  /// Share of the information that a fix states: neighbouring points are on the same surfel, and
  /// err together.
  double share = 0.25;
  double sigma_m = 8e-4;  ///< what all points share: the reference's own error, rounding
  double sigma_rad = 1.2e-3;
  /// How far the directions of fixes are off, one from another: by 0.01 rad, and some 200 in a
  /// row err together.
  double tilt_rad = 0.15;
  double gate = 25;  ///< chi-square of three degrees of freedom: 1.5e-5 by chance
};

constexpr bool Valid(const FixNoiseConfig& c) {
  return Usable({c.share, c.sigma_m, c.sigma_rad, c.tilt_rad, c.gate}) && c.share > 0 &&
         c.share <= 1 && c.sigma_m > 0 && c.sigma_rad > 0 && c.tilt_rad >= 0 && c.gate > 0;
}

/// What a fix tells against a pose that is known with covariance M.
struct FixGain {
  Vector3d y = Vector3d::Zero();            ///< fix less pose
  Mat<3, 3> S_inverse = Mat<3, 3>::Zero();  ///< (M + L⁻¹)⁻¹
  bool within_gate = false;                 ///< y' S⁻¹ y
};

/// With the fix's information I and Σ what all its points share, the placement of the surfaces
/// as far as it is not `common` with M's pose (CommonWith) among them,
///
///   L = ((share I)⁻¹ + Σ)⁻¹,   S⁻¹ = (M + L⁻¹)⁻¹ = C (1 + C' M C)⁻¹ C',   L = C C'
///
/// so that a direction without information has none in S⁻¹, whatever M is. A wall tells of the way
/// to it, along a normal n that is not quite its own. Where M leaves the base e beside its place
/// along the wall, n's tilt by δ makes an error of δ e of that; and many fixes, each by a normal a
/// little different, would feign to tell where along the wall the base is. So Σ has
///
///   tilt² K M_xy K',   K = (0 -1; 1 0)
///
/// beside what is constant.
FixGain GainOf(const Vector3d& pose, const Mat<3, 3>& M, const PoseFix& fix, const Vector3d& common,
               const FixNoiseConfig& config);

}  // namespace pipewright
