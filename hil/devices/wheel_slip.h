// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "platform/core/rng.h"

namespace pipewright::hil {

/// How a differential drive's real motion differs from what its wheels tell.
struct WheelSlipConfig {
  /// Real turn over the turn that the wheels tell: up to 0.3 rad/s, and from 0.6 rad/s on. A
  /// TRACER 2.0 on tile was seen to turn 1.06 and 1.03 times as far as it reported.
  double yaw_scale_slow = 1;
  double yaw_scale_fast = 1;
  double slip = 0;        ///< mean share of a wheel's travel that is lost
  double slip_sigma = 0;  ///< its spread from one patch of floor to the next, each wheel for itself
  std::uint64_t seed = 1;

  bool Valid() const;
};

/// The base as it really moves.
struct BaseMotion {
  double v_mps = 0;
  double omega_radps = 0;
};

/// Wheels on a floor whose grip changes from patch to patch. With rim speeds w, shares s lost,
/// track b, and k the yaw scale at the told rate:
///
///   w = v_told -+ omega_told b/2
///   v = v_told - (s_l w_l + s_r w_r)/2,   omega = k (omega_told - (s_r w_r - s_l w_l)/b)
///
/// s is drawn anew after each 5 cm that a wheel rolls, so that the way lost grows with its root, by
/// slip_sigma sqrt(0.05 m / way) of it beyond the mean.
class WheelSlip {
 public:
  explicit WheelSlip(const WheelSlipConfig& config);

  BaseMotion Motion(const BaseMotion& told, double track_m) const;
  void Roll(double left_m, double right_m);

  /// Something wet on the floor: these shares are lost besides.
  void Spill(double left, double right) { spilt_ = {left, right}; }

 private:
  void Draw(int wheel);
  double Lost(int wheel) const;

  WheelSlipConfig config_;
  Rng rng_;
  std::array<double, 2> slip_{};  ///< left, right
  std::array<double, 2> spilt_{};
  std::array<double, 2> rolled_m_{};  ///< on the present patch
};

}  // namespace pipewright::hil
