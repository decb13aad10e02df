// SPDX-License-Identifier: MIT
#include "ctrl/whole_body/path_follower.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipewright {
namespace {

// Nearer than this the base need not drive to the path's start: turning there would take longer
// than tracking takes to close the gap on the way.
constexpr double kAtStart_m = 0.05;
constexpr double kAtStart_rad = 0.1;

/// Largest t with t |rate_i| ≤ limit_i.
double LargestFactor(const Controls& rate, const Controls& limit) {
  double t = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kControls; ++i) {
    if (std::abs(rate(i)) * t > limit(i)) {
      t = limit(i) / std::abs(rate(i));
    }
  }
  return t;
}

}  // namespace

PathFollower::PathFollower(const FollowerConfig& config, const RobotModel<kArmJoints>& model,
                           double period_s)
    : config_(config),
      period_s_(period_s),
      edge_speeds_(SpeedsOf(model)),
      edge_(Configuration::Zero(), Configuration::Zero()) {
  speed_ << model.base.speed_mps, model.base.turn_radps, JointValues(model, &ArmJoint::speed_radps);
  acceleration_ << model.base.acceleration_mps2, model.base.turn_acceleration_radps2,
      JointValues(model, &ArmJoint::acceleration_max_radps2);
  speed_ *= config.speed_fraction;
  acceleration_ *= config.acceleration_fraction;
}

void PathFollower::Start(const Configuration& q, const Path& path) {
  path_ = path;
  const Configuration& first = path[0];
  const bool at_start = (first.head<2>() - q.head<2>()).squaredNorm() < kAtStart_m * kAtStart_m &&
                        std::abs(WrapAngle(first(2) - q(2))) < kAtStart_rad;
  q_ref_ = at_start ? first : q;
  next_ = at_start ? 1 : 0;
  s_ = s_end_ = 1;
  s_rate_1ps_ = 0;
}

/// Goes to the piece after s_, on the next edge when this one is done.
void PathFollower::NextPiece() {
  const Controls last = du_ds_;
  while (s_ >= s_end_) {
    if (s_ >= 1) {
      if (next_ == path_.size()) {
        du_ds_.setZero();
        s_rate_1ps_ = 0;
        return;
      }
      edge_ = Edge(q_ref_, path_[next_++], edge_speeds_);
      s_ = 0;
    }
    s_end_ = s_ < edge_.s_turned()   ? edge_.s_turned()
             : s_ < edge_.s_driven() ? edge_.s_driven()
                                     : 1;
    du_ds_ = edge_.RateAt((s_ + s_end_) / 2);
    if (du_ds_.isZero(1e-12)) {  // nothing moves here
      s_ = s_end_;
      q_ref_ = edge_.At(s_);
    }
  }
  if (!last.isApprox(du_ds_, 1e-9)) {
    s_rate_1ps_ = 0;
  }
}

double PathFollower::LagFactor(const Configuration& q) const {
  const double lag = std::max({std::sqrt((q_ref_ - q).head<2>().squaredNorm()),
                               std::abs(WrapAngle(q_ref_(2) - q(2))),
                               (q_ref_ - q).tail<kArmJoints>().cwiseAbs().maxCoeff()});
  return std::clamp((config_.lag_stop - lag) / (config_.lag_stop - config_.lag_free), 0.0, 1.0);
}

/// Base: Kanayama et al., A stable tracking control method for an autonomous mobile robot, ICRA
/// 1990, eq. (8), with a heading term that also acts at v = 0. Joints: proportional.
Controls PathFollower::Feedback(const Configuration& q, const Controls& u_ref) const {
  const double c = std::cos(q(2));
  const double s = std::sin(q(2));
  const double dx = q_ref_(0) - q(0);
  const double dy = q_ref_(1) - q(1);
  const double along = c * dx + s * dy;
  const double across = c * dy - s * dx;
  const double turn = WrapAngle(q_ref_(2) - q(2));
  Controls u_n = u_ref;
  u_n(0) = u_ref(0) * std::cos(turn) + config_.k_along_1ps * along;
  u_n(1) += u_ref(0) * config_.k_across_1pm2 * across + config_.k_heading_1ps * std::sin(turn);
  u_n.tail<kArmJoints>() += config_.k_joint_1ps * (q_ref_ - q).tail<kArmJoints>();
  return u_n;
}

PathFollower::Reference PathFollower::Step(const Configuration& q) {
  NextPiece();
  Reference reference;
  if (!at_end()) {
    const double a = LargestFactor(du_ds_, acceleration_);
    const double left = s_end_ - s_;
    const double fastest = LagFactor(q) * LargestFactor(du_ds_, speed_);
    s_rate_1ps_ =
        std::min({s_rate_1ps_ + a * period_s_, fastest, std::sqrt(2 * a * left), left / period_s_});
    const double step = s_rate_1ps_ * period_s_;
    s_ = left - step < 1e-9 ? s_end_ : s_ + step;
    q_ref_ = edge_.At(s_);
    reference.u = s_rate_1ps_ * du_ds_;
  }
  reference.q = q_ref_;
  reference.u_n = Feedback(q, reference.u);
  return reference;
}

}  // namespace pipewright
