// SPDX-License-Identifier: MIT
#include "ctrl/whole_body/whole_body_controller.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace pipewright {
namespace {

Vec<6> Sensor(const Kinematics<kArmJoints>& kinematics) {
  Vec<6> x;
  x << kinematics.p_WS(), kinematics.z_WS();
  return x;
}

Vec<6> SetPoint(const Goal& goal) {
  Vec<6> x;
  x << goal.p_WS, goal.z_WS;
  return x;
}

double Norm(const Vec<6>& x) { return std::sqrt(x.squaredNorm()); }

/// ‖J u + κ x~ − v_d‖² + λ_c ‖u − u_n‖² as ½ u'H u + g'u. J'J by columns: a 9×6·6×9 product of
/// Eigen's links the heap.
QuadraticCost Law(const Mat<6, kControls>& J, const Vec<6>& wanted, const Controls& u_n,
                  double lambda_c) {
  QuadraticCost cost;
  cost.H = 2 * J.transpose().lazyProduct(J);
  cost.H.diagonal().array() += 2 * lambda_c;
  cost.g = -2 * (J.transpose() * wanted + lambda_c * u_n);
  return cost;
}

/// −rate J'(JJ' + μI)⁻¹ x~
Controls Closing(const Mat<6, kControls>& J, const Vec<6>& error, double rate, double damping) {
  Mat<6, 6> gram = J.lazyProduct(J.transpose());
  gram.diagonal().array() += damping;
  const Vec<6> y = gram.llt().solve(error);
  return -rate * (J.transpose() * y);
}

}  // namespace

WholeBodyController::WholeBodyController(const WholeBodyConfig& config,
                                         const RobotModel<kArmJoints>& model,
                                         const RobotShapes& shapes)
    : config_(config),
      model_(model),
      status_(Valid(config) ? Status::kOk : Status::kOutOfRange),
      builder_(config.constraints, model, shapes),
      qp_(config.svfi_rounds),
      follower_(config.follower, model, config.constraints.period_s) {}

void WholeBodyController::Take(const Goal& goal, const Configuration& q, Time now) {
  goal_id_ = goal.id;
  following_ = !goal.path.empty();
  arrived_ = settling_ = false;
  if (following_) {
    follower_.Start(q, goal.path);
  }
  smooth_error_ = -1;
  held_error_ = best_error_ = 1e9;
  held_way_ = best_way_ = -1;
  changed_at_ = better_at_ = now;
}

WholeBodyController::Reference WholeBodyController::MakeReference(const Goal& goal,
                                                                  const Configuration& q,
                                                                  const Mat<6, kControls>& J,
                                                                  const Vec<6>& x, Time now) {
  Reference reference;
  reference.x_d = SetPoint(goal);
  const Vec<6> error = x - reference.x_d;
  if (arrived_ && following_ &&
      (Norm(error) < config_.settle || ToSeconds(now - arrived_at_) >= config_.settle_s)) {
    following_ = false;
    settling_ = true;
  }
  if (settling_) {
    reference.u_n = Closing(J, error, config_.settle_1ps, config_.settle_damping);
  }
  if (!following_) {
    return reference;
  }
  const PathFollower::Reference on_path = follower_.Step(q);
  reference.u_n = on_path.u_n;
  if (follower_.at_end()) {
    arrived_at_ = arrived_ ? arrived_at_ : now;
    arrived_ = true;
    return reference;
  }
  const Kinematics<kArmJoints> kinematics(model_, on_path.q);
  reference.x_d = Sensor(kinematics);
  reference.v_d = kinematics.SensorJacobian() * on_path.u;
  return reference;
}

GoalState WholeBodyController::Watch(double error, Time now) {
  if (error < config_.reached) {
    return GoalState::kReached;
  }
  const double way = follower_.way();
  const double change = config_.stall_change;
  const double period_s = config_.constraints.period_s;
  const double weight = smooth_error_ < 0 ? 1 : period_s / (period_s + config_.smoothing_s);
  smooth_error_ += weight * (error - smooth_error_);
  if (std::abs(smooth_error_ - held_error_) > change || way > held_way_ + change) {
    held_error_ = smooth_error_;
    held_way_ = way;
    changed_at_ = now;
  }
  if (smooth_error_ < best_error_ - change || way > best_way_ + change) {
    best_error_ = smooth_error_ < best_error_ ? smooth_error_ : best_error_;
    best_way_ = way;
    better_at_ = now;
  }
  const bool stalled = ToSeconds(now - changed_at_) >= config_.stall_s ||
                       ToSeconds(now - better_at_) >= config_.give_up_s;
  return stalled ? GoalState::kStalled : GoalState::kMoving;
}

ControlOutput WholeBodyController::Step(const ControlInput& input, Time now) {
  ControlOutput output;
  const RobotState& state = input.state;
  const bool usable =
      status_ == Status::kOk && state.valid && !state.emergency_stop && state.q.allFinite();
  output.progress.id = input.goal.id;
  if (!usable) {
    u_sent_.setZero();
    output.progress.state = input.goal.id == 0 ? GoalState::kNone : GoalState::kMoving;
    changed_at_ = better_at_ = now;  // standing still on purpose is no stall
    return output;
  }
  const Kinematics<kArmJoints> kinematics(model_, state.q);
  builder_.Build(state.q, kinematics, u_sent_, input.scene, input.field, constraints_,
                 input.covariance_q);
  output.stats.rows = constraints_.rows.size() + constraints_.chance.size();
  output.stats.chance_rows = constraints_.chance.size();
  output.stats.dropped_rows = constraints_.dropped;
  output.stats.box_part = constraints_.box_part;
  output.stats.clamped_rows = constraints_.clamped;
  output.stats.points_inside = constraints_.inside;
  output.stats.clearance = constraints_.clearance;
  if (input.goal.id == 0) {
    goal_id_ = 0;
    u_sent_.setZero();
    return output;
  }
  if (input.goal.id != goal_id_) {
    Take(input.goal, state.q, now);
  }
  const Vec<6> x = Sensor(kinematics);
  output.progress.error = Norm(x - SetPoint(input.goal));
  const Mat<6, kControls> J = kinematics.SensorJacobian();
  const Reference reference = MakeReference(input.goal, state.q, J, x, now);
  output.progress.state = Watch(output.progress.error, now);

  const Vec<6> wanted = reference.v_d - config_.kappa_1ps * (x - reference.x_d);
  const QuadraticCost cost = Law(J, wanted, reference.u_n, config_.lambda_c);
  const std::int64_t before_ns = StopwatchNow();
  const ChanceQp::Answer answer = qp_.Solve(cost, constraints_, config_.constraints.svfi, u_sent_);
  output.stats.qp_ns = StopwatchNow() - before_ns;
  output.u = u_sent_ = answer.u;
  output.stats.qp = answer.stats;
  return output;
}

void WholeBodyController::Sent(const Controls& u, ControlStats& stats) {
  if (u != u_sent_) {
    u_sent_ = u;
    if (stats.qp.rounds > 0) {
      ChanceQp::Count(constraints_, u, stats.qp);
    }
  }
}

}  // namespace pipewright
