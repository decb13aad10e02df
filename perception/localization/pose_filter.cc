// SPDX-License-Identifier: MIT
#include "perception/localization/pose_filter.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace pipewright {
namespace {

constexpr double kLearningWay_m = 0.01;  ///< of the wheels, after which a fix tells of the floor
constexpr double kHasMoved_m = 1e-3;     ///< after which a refused fix may tell of a slip
constexpr double kSurprise = 9;          ///< an innovation squared counts as so many means at most
constexpr double kShock = 50;            ///< and one that others agree with
constexpr double kTellsNothing = 1e-6;

constexpr double Squared(double x) { return x * x; }

/// What the base does when its wheels tell this: ((1 + g) s, (1 + k) t).
BaseStep Scaled(const Vec<6>& x, const BaseStep& told, double fast) {
  return {(1 + x(5)) * told.forward_m, (1 + std::lerp(x(3), x(4), fast)) * told.turn_rad};
}

/// ∂(x, y, phi)/∂(x, y, phi, k_slow, k_fast, g) after a step. The chord's length is taken for that
/// of the arc: the steps are short.
Mat<3, 6> Derivative(const Vec<6>& x, const BaseStep& told, double fast) {
  const BaseStep step = Scaled(x, told, fast);
  const double heading = x(2) + step.turn_rad / 2;
  const Vector3d ahead(std::cos(heading), std::sin(heading), 0);
  const Vector3d by_heading(-step.forward_m * ahead.y(), step.forward_m * ahead.x(), 0);
  const Vector3d by_turn_scale = told.turn_rad * (by_heading / 2 + Vector3d::UnitZ());
  Mat<3, 6> F = Mat<3, 6>::Identity();
  F.col(2) += by_heading;
  F.col(3) = (1 - fast) * by_turn_scale;
  F.col(4) = fast * by_turn_scale;
  F.col(5) = told.forward_m * ahead;
  return F;
}

/// Whether no direction is less known by the fix than so. [m, phi at 1 m]
bool TellsAll(const PoseFix& fix, double sigma_most) {
  Eigen::SelfAdjointEigenSolver<Mat<3, 3>> solver;
  solver.computeDirect(fix.information, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()(0) * Squared(sigma_most) > 1;
}

Vector3d Moved(const Vec<6>& x, const BaseStep& told, double fast) {
  return AlongArc(x.head<3>(), Scaled(x, told, fast));
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
  start.x.head<3>() << pose.x_m, pose.y_m, pose.phi_rad;
  start.P.topLeftCorner<3, 3>() = pose.covariance;
  start.W = pose.covariance;
  common_.setZero();
  start.P(3, 3) = start.P(4, 4) = Squared(config_.yaw_scale_sigma);
  start.P(5, 5) = Squared(config_.way_scale_sigma);
  rate_ = {};
  slip_squared_ = Squared(config_.slip_start);
  way_m_ = 0;
  doubted_ = false;
  dissent_.Clear();
  refused_in_row_ = 0;
  taken_in_row_ = 0;
  last_fix_ = Time::min();
}

double PoseFilter::slip() const { return std::sqrt(slip_squared_); }

double PoseFilter::Fast(double w_radps) const {
  const double above = std::fabs(w_radps) - config_.slow_radps;
  return std::clamp(above / (config_.fast_radps - config_.slow_radps), 0.0, 1.0);
}

void PoseFilter::Predict(const Moment& from, Moment& to) const {
  const BaseStep& told = from.step;
  to.x.head<3>() = Moved(from.x, told, from.fast);
  to.x.tail<3>() = from.x.tail<3>();
  Mat<6, 6> F = Mat<6, 6>::Identity();
  F.topRows<3>() = Derivative(from.x, told, from.fast);
  const double heading = from.x(2) + Scaled(from.x, told, from.fast).turn_rad / 2;
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  const double driven = std::fabs(told.forward_m);
  const double turned = std::fabs(told.turn_rad);
  const Vector3d by_forward(c, s, 0);
  const Vector3d by_turn(-told.forward_m * s / 2, told.forward_m * c / 2, 1);
  const double forward_var = Squared(config_.slip.m) * driven;
  const double turn_var =
      Squared(config_.slip.rad_per_m) * driven + Squared(config_.slip.rad_per_rad) * turned;
  const Mat<3, 3> slip =
      by_forward * by_forward.transpose() * forward_var + by_turn * by_turn.transpose() * turn_var;
  const double walk_var = slip_squared_ * Squared(config_.yaw_scale_walk) * turned;
  const Mat<6, 6> FP = F.lazyProduct(from.P);
  to.P = FP.lazyProduct(F.transpose());
  to.P.topLeftCorner<3, 3>() += slip_squared_ * slip;
  const Mat<3, 3> G = F.topLeftCorner<3, 3>();
  to.W = G.lazyProduct(from.W).lazyProduct(G.transpose()) + Squared(config_.slip_worst) * slip;
  to.P(3, 3) += Squared(1 - from.fast) * walk_var;
  to.P(4, 4) += Squared(from.fast) * walk_var;
  to.P(5, 5) += slip_squared_ * Squared(config_.way_scale_walk) * driven;
}

Status PoseFilter::Step(Time now, double v_mps, double w_radps, double left_m, double right_m) {
  const bool first = odometry_.pose().stamp == Newest().stamp && count_ == 1;
  const double fast = Fast((rate_.turn_rad + w_radps) / 2);
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
  way_m_ += std::fabs(moved.forward_m) + std::fabs(moved.turn_rad) * config_.odometry.track_m / 2;
  Moment& from = moments_[newest_];
  from.step = moved;
  from.fast = fast;
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

/// Either the fix is wrong or the pose is.
void PoseFilter::Doubt(bool moved) {
  ++refused_;
  ++refused_in_row_;
  taken_in_row_ = 0;
  if (!doubted_ && (moved || refused_in_row_ >= config_.patience)) {
    doubted_ = true;
    ++doubts_;
  }
}

void PoseFilter::Agree() {
  ++fixes_;
  refused_in_row_ = 0;
  dissent_.Clear();
  if (++taken_in_row_ >= config_.agreement) {
    doubted_ = false;
  }
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
    Doubt(false);
    return Status::kInfeasible;
  }
  const bool has_moved = way_m_ > kHasMoved_m;
  const double way_m = std::exchange(way_m_, 0);
  const double moved = std::min(1.0, way_m / kLearningWay_m);
  const Vector3d common = CommonWith(fix.placed, common_, moments_[i].P);
  TakeOut(common - common_, moments_[i].W);
  common_ = common;
  Replay(i);
  Instant then = At(i, fix);
  if (!then.gain.within_gate) {
    dissent_.Add(fix, then.pose, config_.fix);
    Doubt(has_moved);
    const Vector3d& y = dissent_.offset();
    const bool near = y.head<2>().norm() < config_.lost_m && std::abs(y.z()) < config_.lost_rad;
    const bool explained = then.by_worst.within_gate || TellsAll(fix, config_.lost_m);
    if (dissent_.count() < config_.agreement || !near || !explained) {
      return Status::kInfeasible;
    }
    Slipped(i);
    Startle(i, then.surprise, way_m);
    then = At(i, fix);
  } else if (has_moved && then.surprise > kSurprise) {
    Startle(i, then.surprise, way_m);
    then = At(i, fix);
  } else {
    Learn(moved * (std::min(then.surprise, kSurprise) - 1));
  }
  Agree();
  Take(i, then);
  return Status::kOk;
}

/// The pose at a fix's stamp, moment i being the last before it, and what the fix tells of it.
PoseFilter::Instant PoseFilter::At(int i, const PoseFix& fix) const {
  const Moment& moment = moments_[i];
  const BaseStep step = StepTo(i, fix.stamp);
  const double fast = i == newest_ ? Fast(rate_.turn_rad) : moment.fast;
  const Mat<3, 6> J = Derivative(moment.x, step, fast);
  Instant then;
  then.PJ = moment.P.lazyProduct(J.transpose());
  const Mat<3, 3> M = J.lazyProduct(then.PJ);
  then.pose = Moved(moment.x, step, fast);
  then.gain = GainOf(then.pose, M, fix, common_, config_.fix);
  const Mat<3, 3> G = J.leftCols<3>();
  then.WG = moment.W.lazyProduct(G.transpose());
  then.by_worst = GainOf(then.pose, G.lazyProduct(then.WG), fix, common_, config_.fix);
  then.surprise = Surprise(then.gain, M);
  return then;
}

/// The update of Kalman's filter at moment i.
void PoseFilter::Take(int i, const Instant& then) {
  Moment& moment = moments_[i];
  const Mat<6, 3> K = then.PJ.lazyProduct(then.gain.S_inverse);
  moment.x += K.lazyProduct(then.gain.y);
  const Vector3d most(config_.yaw_scale_max, config_.yaw_scale_max, config_.way_scale_max);
  moment.x.tail<3>() = moment.x.tail<3>().cwiseMax(-most).cwiseMin(most);
  moment.P -= K.lazyProduct(then.PJ.transpose()).eval();
  moment.P = (moment.P + moment.P.transpose()).eval() / 2;
  const Mat<3, 3> WS = then.WG.lazyProduct(then.by_worst.S_inverse);
  moment.W -= WS.lazyProduct(then.WG.transpose()).eval();
  moment.W = (moment.W + moment.W.transpose()).eval() / 2;
  Replay(i);
}

/// y' S⁻¹ M S⁻¹ y over its mean: how much larger the wheels' variance would be by this fix.
double PoseFilter::Surprise(const FixGain& gain, const Mat<3, 3>& M) {
  const Vector3d weighed = gain.S_inverse.lazyProduct(gain.y);
  const double expected = gain.S_inverse.cwiseProduct(M).sum();  // tr(S⁻¹ M)
  return expected > kTellsNothing ? weighed.dot(M.lazyProduct(weighed)) / expected : 1;
}

void PoseFilter::Learn(double surplus) {
  slip_squared_ = std::clamp(slip_squared_ * std::exp(config_.slip_learning * surplus),
                             Squared(config_.slip_least), Squared(config_.slip_most));
  TellOdometry();
}

/// The fixes are right: a wheel has slipped by their offset before moment i. What a wheel loses
/// turns the base more than it keeps it back.
void PoseFilter::Slipped(int i) {
  ++slips_;
  const Vector3d& y = dissent_.offset();
  const double half_track_m = config_.odometry.track_m / 2;
  const double lost2 = std::max(y.head<2>().squaredNorm(), Squared(half_track_m * y.z()));
  moments_[i].P.diagonal().head<3>() += Vector3d(lost2, lost2, lost2 / Squared(half_track_m));
}

/// A surprise that chance does not bring: the floor is that much more slippery at once, and was on
/// the way to moment i since the last fix, in all directions.
void PoseFilter::Startle(int i, double surprise, double way_m) {
  const double factor = std::clamp(surprise, 1.0, kShock);
  slip_squared_ =
      std::clamp(slip_squared_ * factor, Squared(config_.slip_least), Squared(config_.slip_most));
  const double way_var = slip_squared_ * Squared(config_.slip.m) * way_m;
  const double turn_var = slip_squared_ * Squared(config_.slip.rad_per_m) * way_m;
  moments_[i].P.diagonal().head<3>() += Vector3d(way_var, way_var, turn_var);
  TellOdometry();
}

/// The wheels' error for as long as no fix corrects it. That of the yaw scale grows with the turn,
/// not its root: it counts as after 1 rad.
void PoseFilter::TellOdometry() {
  const double f = slip();
  const double yaw_scale_var = std::max(Newest().P(3, 3), Newest().P(4, 4));
  odometry_.Slips(
      {.m = f * config_.slip.m,
       .rad_per_m = f * config_.slip.rad_per_m,
       .rad_per_rad = std::sqrt(Squared(f * config_.slip.rad_per_rad) + yaw_scale_var)});
}

BasePose PoseFilter::pose() const {
  const Moment& now = Newest();
  BasePose pose{.stamp = now.stamp, .x_m = now.x(0), .y_m = now.x(1), .phi_rad = now.x(2)};
  pose.covariance = WithShared(now.P.topLeftCorner<3, 3>());
  return pose;
}

Mat<3, 3> PoseFilter::worst_covariance() const { return WithShared(Newest().W); }

/// What the pose has in common with its surroundings, and what all fixes share.
Mat<3, 3> PoseFilter::WithShared(Mat<3, 3> covariance) const {
  covariance.diagonal() += common_;
  if (fixes_ > 0) {
    const double of_place = Squared(config_.fix.sigma_m);
    covariance.diagonal() += Vector3d(of_place, of_place, Squared(config_.fix.sigma_rad));
  }
  return covariance;
}

BasePose PoseFilter::Extrapolate(Time when) const {
  BasePose pose = this->pose();
  const double dt_s =
      ToSeconds(std::clamp(when - pose.stamp, Duration::zero(), config_.odometry.max_gap));
  const Vector3d moved =
      Moved(Newest().x, {rate_.forward_m * dt_s, rate_.turn_rad * dt_s}, Fast(rate_.turn_rad));
  pose.stamp = when;
  pose.x_m = moved.x();
  pose.y_m = moved.y();
  pose.phi_rad = moved.z();
  return pose;
}

bool PoseFilter::lost() const {
  const Vector3d variance = Newest().P.diagonal().head<3>() + common_;
  return variance(0) + variance(1) > Squared(config_.lost_m) ||
         variance(2) > Squared(config_.lost_rad);
}

}  // namespace pipewright
