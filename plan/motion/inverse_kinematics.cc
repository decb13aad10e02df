// SPDX-License-Identifier: MIT
#include "plan/motion/inverse_kinematics.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "plan/motion/edge.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

using Body = Kinematics<kArmJoints>;

/// [p_d - p; the rotation vector that turns z onto z_d].
Vec<6> ErrorOf(const SensorTarget& target, const Body& body) {
  const Vector3d z = body.z_WS();
  const Vector3d across = z.cross(target.z_WS);
  const double sine = std::sqrt(across.squaredNorm());
  const double angle_rad = std::atan2(sine, z.dot(target.z_WS));
  constexpr double kParallel = 1e-9;
  Vector3d turn = across;
  if (sine > kParallel) {
    turn *= angle_rad / sine;
  } else if (z.dot(target.z_WS) < 0) {  // opposite: about any axis across z
    turn = angle_rad * body.X_WS().linear().col(0);
  }
  Vec<6> error;
  error << target.p_WS - body.p_WS(), turn;
  return error;
}

/// Position and rotation of S against q, the base moving freely in the plane.
Mat<6, kDof> JacobianOf(const Body& body) {
  Mat<6, kDof> J = Mat<6, kDof>::Zero();
  const auto J_p = body.PointJacobianAt(Body::kTool, body.p_WS());
  J(0, 0) = 1;
  J(1, 1) = 1;
  J.block<3, 1>(0, 2) = J_p.col(1);
  J(5, 2) = 1;
  for (int i = 0; i < kArmJoints; ++i) {
    J.block<3, 1>(0, 3 + i) = J_p.col(2 + i);
    J.block<3, 1>(3, 3 + i) = body.X_WL(1 + i).linear().col(2);
  }
  return J;
}

/// w J' (J w J' + damping)^-1 error, of bounded length.
Configuration StepOf(const Mat<6, kDof>& J, const Configuration& weights, const Vec<6>& error) {
  constexpr double kDamping = 1e-4;
  constexpr double kLongest = 0.5;  // rad or m, any coordinate
  Mat<6, 6> A = kDamping * Mat<6, 6>::Identity();
  for (int i = 0; i < kDof; ++i) {
    A += weights(i) * J.col(i) * J.col(i).transpose();
  }
  const Vec<6> y = A.llt().solve(error);
  Configuration step;
  for (int i = 0; i < kDof; ++i) {
    step(i) = weights(i) * J.col(i).dot(y);
  }
  return step * std::min(1.0, kLongest / std::max(step.cwiseAbs().maxCoeff(), 1e-12));
}

struct JointRange {
  ArmVector lo;
  ArmVector hi;
};

/// The planner's limits: the device's, less the checker's margin.
JointRange PlannedRange() {
  const double margin_rad = CollisionConfig{}.joint_margin_rad + 1e-6;
  return {JointValues(TracerUf7(), &ArmJoint::q_min_rad).array() + margin_rad,
          JointValues(TracerUf7(), &ArmJoint::q_max_rad).array() - margin_rad};
}

/// A posture about home, half of the attempts with another stand of the base.
Configuration RandomPosture(const Configuration& seed, const ReachConfig& config,
                            const JointRange& range, Rng& rng) {
  constexpr double kShift_m = 0.4;
  constexpr double kTurn_rad = 1.2;
  Configuration q = seed;
  if (!config.hold_base && rng.Uniform() < 0.5) {
    q(0) += rng.Uniform(-kShift_m, kShift_m);
    q(1) += rng.Uniform(-kShift_m, kShift_m);
    q(2) += rng.Uniform(-kTurn_rad, kTurn_rad);
  }
  for (int i = 0; i < kArmJoints; ++i) {
    const double lo = std::max(range.lo(i), -std::numbers::pi);
    const double hi = std::min(range.hi(i), std::numbers::pi);
    q(3 + i) = rng.Uniform(lo, hi);
  }
  return q;
}

}  // namespace

std::optional<Configuration> SolveSensor(const SensorTarget& target, const Configuration& seed,
                                         const ReachConfig& config) {
  if (!seed.allFinite() || !target.p_WS.allFinite() || !target.z_WS.allFinite()) {
    return std::nullopt;
  }
  const JointRange range = PlannedRange();
  Configuration willing = Configuration::Ones();
  willing.head<3>().setConstant(config.hold_base ? 0 : config.base_weight);
  Configuration q = seed;
  q.tail<kArmJoints>() = q.tail<kArmJoints>().cwiseMax(range.lo).cwiseMin(range.hi);
  for (int iteration = 0; iteration < config.iterations; ++iteration) {
    const Body body(TracerUf7(), q);
    const Vec<6> error = ErrorOf(target, body);
    if (error.head<3>().squaredNorm() <= config.position_m * config.position_m &&
        error.tail<3>().squaredNorm() <= config.axis * config.axis) {
      return q;
    }
    const Mat<6, kDof> J = JacobianOf(body);
    Configuration weights = willing;
    Configuration step = StepOf(J, weights, error);
    bool blocked = false;
    for (int i = 0; i < kArmJoints; ++i) {
      const bool beyond = (q(3 + i) <= range.lo(i) && step(3 + i) < 0) ||
                          (q(3 + i) >= range.hi(i) && step(3 + i) > 0);
      if (beyond) {
        weights(3 + i) = 0;
        blocked = true;
      }
    }
    if (blocked) {
      step = StepOf(J, weights, error);
    }
    q += step;
    q.tail<kArmJoints>() = q.tail<kArmJoints>().cwiseMax(range.lo).cwiseMin(range.hi);
  }
  return std::nullopt;
}

Configuration Unwound(const Configuration& q, const Configuration& reference) {
  const JointRange range = PlannedRange();
  Configuration unwound = q;
  for (int i = 0; i < kArmJoints; ++i) {
    const double nearest = reference(3 + i) + WrapAngle(q(3 + i) - reference(3 + i));
    if (range.lo(i) <= nearest && nearest <= range.hi(i)) {
      unwound(3 + i) = nearest;
    }
  }
  return unwound;
}

std::optional<Configuration> Reach(const CollisionChecker& checker, const SensorTarget& target,
                                   const Configuration& seed, Rng& rng, const ReachConfig& config) {
  const JointRange range = PlannedRange();
  for (int attempt = 0; attempt < config.attempts; ++attempt) {
    const Configuration start = attempt < 2 ? seed : RandomPosture(seed, config, range, rng);
    ReachConfig this_time = config;
    this_time.hold_base = config.hold_base || attempt % 2 == 0;
    const std::optional<Configuration> q = SolveSensor(target, start, this_time);
    if (q && checker.Free(*q)) {
      return Unwound(*q, seed);
    }
  }
  return std::nullopt;
}

}  // namespace pipewright
