// SPDX-License-Identifier: MIT
#include "ctrl/constraints/constraint_set.h"

#include <algorithm>
#include <cassert>

#include "ctrl/constraints/row_maker.h"
#include "ctrl/constraints/self_rows.h"
#include "ctrl/constraints/world_rows.h"

namespace pipewright {
namespace {

/// Speeds, accelerations and joint positions; braking is limited in reach_lb, reach_ub alone, for u
/// = 0 must stay in the box.
void BoundControls(const ConstraintConfig& config, const RobotModel<kArmJoints>& model,
                   const Configuration& q, const Controls& u_sent, ConstraintSet& out) {
  const bool soft = config.Price(RowKind::kJointVelocity) > 0;
  const auto bound = [&](int i, double speed, double acceleration) {
    const double step = acceleration * config.period_s;
    out.lb(i) = std::clamp(u_sent(i) - step, -speed, 0.0);
    out.ub(i) = std::clamp(u_sent(i) + step, 0.0, speed);
  };
  bound(0, model.base.speed_mps, model.base.acceleration_mps2);
  bound(1, model.base.turn_radps, model.base.turn_acceleration_radps2);
  for (int j = 0; j < kArmJoints; ++j) {
    const ArmJoint& joint = model.arm.joints[j];
    const int i = 2 + j;
    bound(i, soft ? joint.speed_max_radps : joint.speed_radps, joint.acceleration_max_radps2);
    const double to_min = config.eta_joint_1ps * (joint.q_min_rad - q(3 + j));
    const double to_max = config.eta_joint_1ps * (joint.q_max_rad - q(3 + j));
    out.lb(i) = std::max(out.lb(i), std::min(to_min, 0.0));
    out.ub(i) = std::min(out.ub(i), std::max(to_max, 0.0));
  }
  const auto reach = [&](int i, double acceleration) {
    const double step = acceleration * config.period_s;
    out.reach_lb(i) = std::clamp(u_sent(i) - step, out.lb(i), out.ub(i));
    out.reach_ub(i) = std::clamp(u_sent(i) + step, out.lb(i), out.ub(i));
  };
  reach(0, model.base.acceleration_mps2);
  reach(1, model.base.turn_acceleration_radps2);
  for (int j = 0; j < kArmJoints; ++j) {
    reach(2 + j, model.arm.joints[j].acceleration_max_radps2);
  }
}

void Clear(ConstraintSet& out) {
  out.rows.clear();
  out.chance.clear();
  out.dropped = out.clamped = out.inside = 0;
  out.box_part = 1;
  out.clearance = {};
}

}  // namespace

ConstraintBuilder::ConstraintBuilder(const ConstraintConfig& config,
                                     const RobotModel<kArmJoints>& model, const RobotShapes& shapes)
    : config_(config), model_(model), shapes_(shapes) {
  const Result<double> z = ChanceQuantile(config.alpha);
  z_ = z.ok() ? *z : 0;
}

void ConstraintBuilder::Build(const Configuration& q, const Kinematics<kArmJoints>& kinematics,
                              const Controls& u_sent, const Scene& scene,
                              const DistanceField& field, ConstraintSet& out,
                              const StateCovariance* covariance_q) const {
  Clear(out);
  out.z = z_;
  BoundControls(config_, model_, q, u_sent, out);
  if (field.empty()) {  // nothing was ever seen
    out.lb.setZero();
    out.ub.setZero();
    out.reach_lb.setZero();
    out.reach_ub.setZero();
    return;
  }
  const RowContext context{
      config_, kinematics, shapes_, u_sent, out.lb.cwiseAbs().cwiseMax(out.ub), covariance_q};
  if (config_.joint_risk) {  // how many rows share the risk does not depend on z
    RowMaker counter(config_, z_, out);
    AddWorldRows(context, scene, field, counter, out.clearance);
    const Result<double> z = JointChanceQuantile(config_.alpha, counter.chance_rows());
    Clear(out);
    out.z = z.ok() ? *z : z_;
  }
  RowMaker maker(config_, out.z, out);
  for (int j = 0; j < kArmJoints; ++j) {
    const double speed = model_.arm.joints[j].speed_radps;
    if (out.lb(2 + j) < -speed || out.ub(2 + j) > speed) {
      maker.JointSpeed(2 + j, speed);
    }
  }
  AddWorldRows(context, scene, field, maker, out.clearance);
  AddSelfRows(context, maker, out.clearance);
  maker.Finish();
}

}  // namespace pipewright
