// SPDX-License-Identifier: MIT
#pragma once

#include "perception/primitives/depth_view.h"
#include "perception/primitives/fit.h"
#include "perception/primitives/four_floats.h"

namespace pipewright {

/// A cylinder without ends in a form that is cheap to ask where rays meet it, in single precision.
///
/// With the ray x = (X/Z, Y/Z, 1), a = x − l (l'x), c = p − l (l'p) and m = p × l,
///   |z a − c|² = r²  =>  z = (B − D^½)/A,   A = |a|², B = a'c, D = B² − A (|c|² − r²)
///                                                               = r² A − (m'x)²
/// The last form of D loses no digits to cancellation.
class PipeRays {
 public:
  explicit PipeRays(const CylinderFit& pipe)
      : l_(pipe.l_S.cast<float>()),
        c_((pipe.p_S - pipe.l_S.dot(pipe.p_S) * pipe.l_S).cast<float>()),
        m_(pipe.p_S.cross(pipe.l_S).cast<float>()),
        lp_(static_cast<float>(pipe.l_S.dot(pipe.p_S))),
        r2_(static_cast<float>(pipe.radius_m * pipe.radius_m)),
        outside_(c_.squaredNorm() > r2_) {}

  /// Where the rays of four pixels enter the cylinder.
  struct Entry {
    Masks meets;  ///< it does, and there is a reading; else the numbers mean nothing
    Floats z_m;
    Floats s_m;      ///< along the axis from p
    Floats cosine2;  ///< of the angle between ray and surface normal, squared
  };

  /// Calls use(i, entry) for the pixels i ... i + 3 of a view where any ray meets the cylinder.
  /// Cost: ~2 ns a pixel, ~6 ns where it meets.
  template <typename Use>
  void ForMeeting(const DepthView& view, const Use& use) const {
    for (int i = 0; i < view.size() && outside_; i += kLanes) {
      const Floats x = view.four_x(i);
      const Floats y = view.four_y(i);
      const Floats x2 = x * x + y * y + 1;
      const Floats lx = l_.x() * x + l_.y() * y + l_.z();
      const Floats A = x2 - lx * lx;
      const Floats mx = m_.x() * x + m_.y() * y + m_.z();
      const Floats D = r2_ * A - mx * mx;
      const Masks crosses = (D > 0) & (view.four_inverse_z(i) > 0);
      if (!Any(crosses)) {
        continue;
      }
      const Floats B = c_.x() * x + c_.y() * y + c_.z();  // a'c = x'c, for c is across l
      const Floats z_m = (B - SquareRoot(D)) / A;
      use(i, Entry{crosses & (z_m > 0), z_m, z_m * lx - lp_, D / (r2_ * x2)});
    }
  }

 private:
  Eigen::Vector3f l_, c_, m_;
  float lp_;
  float r2_;
  bool outside_;  ///< is the camera; from inside no ray enters
};

}  // namespace pipewright
