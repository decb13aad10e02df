// SPDX-License-Identifier: MIT
#include "hil/devices/wheel_slip.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pipewright::hil {
namespace {

constexpr double kPatch_m = 0.05;
constexpr double kSlow_radps = 0.3;
constexpr double kFast_radps = 0.6;

bool IsShare(double x) { return x >= 0 && x <= 1; }

}  // namespace

bool WheelSlipConfig::Valid() const {
  return yaw_scale_slow > 0 && std::isfinite(yaw_scale_slow) && yaw_scale_fast > 0 &&
         std::isfinite(yaw_scale_fast) && IsShare(slip) && IsShare(slip_sigma);
}

WheelSlip::WheelSlip(const WheelSlipConfig& config) : config_(config), rng_(config.seed) {
  assert(config.Valid());
  Draw(0);
  Draw(1);
}

void WheelSlip::Draw(int wheel) {
  slip_[wheel] = config_.slip + config_.slip_sigma * rng_.Normal();
}

double WheelSlip::Lost(int wheel) const {
  return std::clamp(slip_[wheel] + spilt_[wheel], -1.0, 1.0);
}

BaseMotion WheelSlip::Motion(const BaseMotion& told, double track_m) const {
  const double fast = std::clamp(
      (std::abs(told.omega_radps) - kSlow_radps) / (kFast_radps - kSlow_radps), 0.0, 1.0);
  const double yaw_scale = std::lerp(config_.yaw_scale_slow, config_.yaw_scale_fast, fast);
  const double left = Lost(0) * (told.v_mps - told.omega_radps * track_m / 2);
  const double right = Lost(1) * (told.v_mps + told.omega_radps * track_m / 2);
  return {told.v_mps - (left + right) / 2,
          yaw_scale * (told.omega_radps - (right - left) / track_m)};
}

void WheelSlip::Roll(double left_m, double right_m) {
  const std::array<double, 2> way_m = {std::abs(left_m), std::abs(right_m)};
  for (int wheel = 0; wheel < 2; ++wheel) {
    rolled_m_[wheel] += way_m[wheel];
    if (rolled_m_[wheel] >= kPatch_m) {
      rolled_m_[wheel] = 0;
      Draw(wheel);
    }
  }
}

}  // namespace pipewright::hil
