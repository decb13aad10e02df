// SPDX-License-Identifier: MIT
#include "perception/localization/pose_filter.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace pipewright {
namespace {

constexpr double kDoubt =
    1.5;  ///< a second of doubts at 15 Hz: standard deviations 20 times as wide

constexpr double Squared(double x) { return x * x; }

/// ∂(x, y, phi)/∂(x, y, phi, k) after a step. The chord's length is taken for that of the arc: the
/// steps are short.
Mat<3, 4> Derivative(const Vec<4>& x, const BaseStep& told) {
  const double heading = x(2) + (1 + x(3)) * told.turn_rad / 2;
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  Mat<3, 4> F = Mat<3, 4>::Identity();
  F(0, 2) = -told.forward_m * s;
  F(1, 2) = told.forward_m * c;
  F(0, 3) = -told.forward_m * s * told.turn_rad / 2;
  F(1, 3) = told.forward_m * c * told.turn_rad / 2;
  F(2, 3) = told.turn_rad;
  return F;
}

Vector3d Moved(const Vec<4>& x, const BaseStep& told) {
  return AlongArc(x.head<3>(), {told.forward_m, (1 + x(3)) * told.turn_rad});
}

}  // namespace

PoseFilter::PoseFilter(const PoseFilterConfig& config)
    : config_(config), odometry_(config.odometry) {
  assert(Valid(config));
  Reset({});
}

void PoseFilter::Reset(const BasePose& pose) {
  odometry_.Reset(pose);
  newest_ = 0;
  count_ = 1;
  Moment& start = moments_[0];
  start = {};
  start.stamp = pose.stamp;
  start.x << pose.x_m, pose.y_m, pose.phi_rad, 0;
  start.P.topLeftCorner<3, 3>() = pose.covariance;
  start.P(3, 3) = Squared(config_.yaw_scale_sigma);
  rate_ = {};
  last_fix_ = Time::min();
}

void PoseFilter::Predict(const Moment& from, Moment& to) const {
  const BaseStep& told = from.step;
  to.x.head<3>() = Moved(from.x, told);
  to.x(3) = from.x(3);
  Mat<4, 4> F = Mat<4, 4>::Identity();
  F.topRows<3>() = Derivative(from.x, told);
  const double heading = from.x(2) + (1 + from.x(3)) * told.turn_rad / 2;
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  const double driven = std::fabs(told.forward_m);
  const double turned = std::fabs(told.turn_rad);
  const Vec<4> by_forward(c, s, 0, 0);
  const Vec<4> by_turn(-told.forward_m * s / 2, told.forward_m * c / 2, 1, 0);
  const double turn_var =
      Squared(config_.slip_rad_per_m) * driven + Squared(config_.slip_rad_per_rad) * turned;
  const Mat<4, 4> FP = F.lazyProduct(from.P);
  to.P = FP.lazyProduct(F.transpose());
  to.P += by_forward * by_forward.transpose() * (Squared(config_.slip_m) * driven) +
          by_turn * by_turn.transpose() * turn_var;
  to.P(3, 3) += Squared(config_.yaw_scale_walk) * turned;
}

Status PoseFilter::Step(Time now, double v_mps, double w_radps, double left_m, double right_m) {
  const bool first = odometry_.pose().stamp == Newest().stamp && count_ == 1;
  const Status status = odometry_.Step(now, v_mps, w_radps, left_m, right_m);
  if (status != Status::kOk && status != Status::kFault) {
    return status;
  }
  rate_ = {v_mps, w_radps};
  const BaseStep& moved = odometry_.moved();
  if (first && moved.forward_m == 0 && moved.turn_rad == 0) {
    moments_[newest_].stamp = now;  // still where it was switched on
    return status;
  }
  Moment& from = moments_[newest_];
  from.step = moved;
  newest_ = (newest_ + 1) % kSteps;
  count_ = std::min(count_ + 1, kSteps);
  moments_[newest_].stamp = now;
  Predict(from, moments_[newest_]);
  return status;
}

/// Index of the newest moment that is not newer than the stamp; -1: all are.
int PoseFilter::Before(Time stamp) const {
  for (int age = 0; age < count_; ++age) {
    const int i = (newest_ + kSteps - age) % kSteps;
    if (moments_[i].stamp <= stamp) {
      return i;
    }
  }
  return -1;
}

/// What the wheels tell of the way from moment i to a stamp before the next one.
BaseStep PoseFilter::StepTo(int i, Time stamp) const {
  const Moment& from = moments_[i];
  const double after_s = ToSeconds(stamp - from.stamp);
  if (i == newest_) {
    return {rate_.forward_m * after_s, rate_.turn_rad * after_s};
  }
  const double share = after_s / ToSeconds(moments_[(i + 1) % kSteps].stamp - from.stamp);
  return {share * from.step.forward_m, share * from.step.turn_rad};
}

void PoseFilter::Replay(int from) {
  for (int i = from; i != newest_; i = (i + 1) % kSteps) {
    Predict(moments_[i], moments_[(i + 1) % kSteps]);
  }
}

/// Either the fix of that moment is wrong or the pose is.
void PoseFilter::Doubt(int i) {
  ++refused_;
  Mat<4, 4>& P = moments_[i].P;
  P.topLeftCorner<3, 3>() *= kDoubt;
  P(0, 0) += Squared(config_.fix_sigma_m);
  P(1, 1) += Squared(config_.fix_sigma_m);
  P(2, 2) += Squared(config_.fix_sigma_rad);
  Replay(i);
}

Status PoseFilter::Correct(const PoseFix& fix) {
  if (!fix.pose.allFinite() || !fix.information.allFinite() ||
      fix.stamp - Newest().stamp > config_.odometry.max_gap) {
    return Status::kOutOfRange;
  }
  const int i = Before(fix.stamp);
  if (i < 0 || fix.stamp <= last_fix_) {
    return Status::kStale;
  }
  last_fix_ = fix.stamp;
  if (!fix.fits) {
    Doubt(i);
    return Status::kInfeasible;
  }
  Moment& then = moments_[i];
  const BaseStep step = StepTo(i, fix.stamp);
  const Mat<3, 4> J = Derivative(then.x, step);
  Vector3d y = fix.pose - Moved(then.x, step);
  y.z() = std::remainder(y.z(), 2 * std::numbers::pi);

  // L = (I⁻¹ + Σ)⁻¹ = Σ⁻¹ - Σ⁻¹ (I + Σ⁻¹)⁻¹ Σ⁻¹, for an I that may be singular.
  const Vector3d shared(1 / Squared(config_.fix_sigma_m), 1 / Squared(config_.fix_sigma_m),
                        1 / Squared(config_.fix_sigma_rad));
  const Mat<3, 3> W = shared.asDiagonal();
  const Mat<3, 3> sum = fix.information + W;
  const Mat<3, 3> inner = sum.inverse().lazyProduct(W);
  Mat<3, 3> L = W - W.lazyProduct(inner);
  L = (L + L.transpose()).eval() / 2;
  L.diagonal().array() +=
      1e-9;  // to be definite, not to say anything: a standard deviation of 30 km
  const Mat<3, 3> C = L.llt().matrixL();
  const Mat<4, 3> PJ = then.P.lazyProduct(J.transpose());
  const Mat<3, 3> M = J.lazyProduct(PJ);
  const Mat<3, 3> MC = M.lazyProduct(C);
  const Mat<3, 3> A = Mat<3, 3>::Identity() + C.transpose().lazyProduct(MC);
  const Mat<3, 3> AC = A.inverse().lazyProduct(C.transpose());
  const Mat<3, 3> S_inverse = C.lazyProduct(AC);

  const double distance = y.dot(S_inverse.lazyProduct(y));
  if (!(distance <= config_.gate)) {
    Doubt(i);
    return Status::kInfeasible;
  }
  ++fixes_;
  const Mat<4, 3> K = PJ.lazyProduct(S_inverse);
  then.x += K.lazyProduct(y);
  then.x(3) = std::clamp(then.x(3), -config_.yaw_scale_max, config_.yaw_scale_max);
  then.P -= K.lazyProduct(PJ.transpose()).eval();
  then.P = (then.P + then.P.transpose()).eval() / 2;
  Replay(i);
  return Status::kOk;
}

BasePose PoseFilter::pose() const {
  const Moment& now = Newest();
  BasePose pose{.stamp = now.stamp, .x_m = now.x(0), .y_m = now.x(1), .phi_rad = now.x(2)};
  pose.covariance = now.P.topLeftCorner<3, 3>();
  if (fixes_ > 0) {
    const double of_place = Squared(config_.fix_sigma_m);
    pose.covariance.diagonal() += Vector3d(of_place, of_place, Squared(config_.fix_sigma_rad));
  }
  return pose;
}

BasePose PoseFilter::Extrapolate(Time when) const {
  BasePose pose = this->pose();
  const double dt_s =
      ToSeconds(std::clamp(when - pose.stamp, Duration::zero(), config_.odometry.max_gap));
  const Vector3d moved = Moved(Newest().x, {rate_.forward_m * dt_s, rate_.turn_rad * dt_s});
  pose.stamp = when;
  pose.x_m = moved.x();
  pose.y_m = moved.y();
  pose.phi_rad = moved.z();
  return pose;
}

bool PoseFilter::lost() const {
  const Mat<4, 4>& P = Newest().P;
  return P(0, 0) + P(1, 1) > Squared(config_.lost_m) || P(2, 2) > Squared(config_.lost_rad);
}

}  // namespace pipewright
