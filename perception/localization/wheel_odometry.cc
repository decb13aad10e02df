// SPDX-License-Identifier: MIT
#include "perception/localization/wheel_odometry.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pipewright {
namespace {

void MoveAlongArc(BasePose& pose, const BaseStep& step) {
  const Vector3d moved = AlongArc({pose.x_m, pose.y_m, pose.phi_rad}, step);
  pose.x_m = moved.x();
  pose.y_m = moved.y();
  pose.phi_rad = moved.z();
}

}  // namespace

/// A chord of length s sin(t/2)/(t/2) at heading phi + t/2, for arc s and turn t.
Vector3d AlongArc(const Vector3d& pose, const BaseStep& step) {
  const double half = step.turn_rad / 2;
  const double sinc = std::fabs(half) < 1e-4 ? 1 - half * half / 6 : std::sin(half) / half;
  const double chord = step.forward_m * sinc;
  return {pose.x() + chord * std::cos(pose.z() + half),
          pose.y() + chord * std::sin(pose.z() + half), pose.z() + step.turn_rad};
}

WheelOdometry::WheelOdometry(const WheelOdometryConfig& config) : config_(config) {
  assert(Valid(config));
}

void WheelOdometry::Reset(const BasePose& pose) {
  pose_ = pose;
  moved_ = {};
  slip_covariance_ = pose.covariance;
  v_mps_ = 0;
  w_radps_ = 0;
  started_ = false;
}

Status WheelOdometry::Step(Time now, double v_mps, double w_radps, double left_m, double right_m) {
  if (!std::isfinite(v_mps) || !std::isfinite(w_radps) || !std::isfinite(left_m) ||
      !std::isfinite(right_m)) {
    return Status::kOutOfRange;
  }
  if (!started_) {  // the first report only tells where the wheels' counts begin
    started_ = true;
    Remember(now, v_mps, w_radps, left_m, right_m);
    return Status::kOk;
  }
  if (now <= pose_.stamp) {
    return Status::kStale;
  }
  const Duration gap = now - pose_.stamp;
  const double dt_s = gap > config_.max_gap ? 0 : ToSeconds(gap);
  const double v_mean = (v_mps_ + v_mps) / 2;
  const double turn_mean = (w_radps_ + w_radps) / 2 * config_.track_m / 2;
  const double left_step = (v_mean - turn_mean) * dt_s;
  const double right_step = (v_mean + turn_mean) * dt_s;
  const double reach_m = config_.max_wheel_mps * ToSeconds(gap) + 3 * config_.quantum_m;
  const bool jumped =
      std::fabs(left_m - left_m_) > reach_m || std::fabs(right_m - right_m_) > reach_m;
  if (jumped) {
    ++jumps_;
    Advance(left_step, right_step);
    Remember(now, v_mps, w_radps, left_m, right_m);
    return Status::kFault;
  }
  const double half = config_.quantum_m / 2;
  const double left = std::clamp(left_m_ + left_step, left_m - half, left_m + half);
  const double right = std::clamp(right_m_ + right_step, right_m - half, right_m + half);
  Advance(left - left_m_, right - right_m_);
  Remember(now, v_mps, w_radps, left, right);
  return Status::kOk;
}

void WheelOdometry::Remember(Time now, double v_mps, double w_radps, double left_m,
                             double right_m) {
  pose_.stamp = now;
  v_mps_ = v_mps;
  w_radps_ = w_radps;
  left_m_ = left_m;
  right_m_ = right_m;
}

BasePose WheelOdometry::Extrapolate(Time when) const {
  BasePose pose = pose_;
  const double dt_s = ToSeconds(std::clamp(when - pose_.stamp, Duration::zero(), config_.max_gap));
  MoveAlongArc(pose, {v_mps_ * dt_s, w_radps_ * dt_s});
  pose.stamp = when;
  return pose;
}

Mat<3, 3> WheelOdometry::CovarianceSince(const BasePose& then) const {
  Mat<3, 3> F = Mat<3, 3>::Identity();
  F(0, 2) = -(pose_.y_m - then.y_m);
  F(1, 2) = pose_.x_m - then.x_m;
  // then.covariance has R in it, too.
  Mat<3, 3> of_then = -then.covariance;
  of_then.diagonal() += 2 * RoundingVariance();
  return pose_.covariance + F.lazyProduct(of_then).lazyProduct(F.transpose());
}

/// Of (x, y, phi), from the rounding of the two wheel distances: it does not grow.
Vector3d WheelOdometry::RoundingVariance() const {
  const double of_wheel = config_.quantum_m * config_.quantum_m / 12;
  return {of_wheel, of_wheel, 2 * of_wheel / (config_.track_m * config_.track_m)};
}

/// Moves the pose by the wheels' steps. Covariance: P <- F P F' + V diag(slip variances) V', F and
/// V the motion's derivatives by pose and by (forward, turn); what is reported adds the rounding.
void WheelOdometry::Advance(double left_m, double right_m) {
  const BaseStep d{(left_m + right_m) / 2, (right_m - left_m) / config_.track_m};
  const double heading = pose_.phi_rad + d.turn_rad / 2;
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  MoveAlongArc(pose_, d);
  moved_ = d;

  const double driven = std::fabs(d.forward_m);
  const double turned = std::fabs(d.turn_rad);
  const auto squared = [](double x) { return x * x; };
  const double forward_var = squared(config_.slip.m) * driven;
  const double turn_var =
      squared(config_.slip.rad_per_m) * driven + squared(config_.slip.rad_per_rad) * turned;
  Mat<3, 3> F = Mat<3, 3>::Identity();
  F(0, 2) = -d.forward_m * s;
  F(1, 2) = d.forward_m * c;
  const Vector3d by_forward(c, s, 0);
  const Vector3d by_turn(-d.forward_m * s / 2, d.forward_m * c / 2, 1);
  slip_covariance_ = F.lazyProduct(slip_covariance_).lazyProduct(F.transpose()).eval() +
                     by_forward * by_forward.transpose() * forward_var +
                     by_turn * by_turn.transpose() * turn_var;

  pose_.covariance = slip_covariance_;
  pose_.covariance.diagonal() += RoundingVariance();
}

}  // namespace pipewright
