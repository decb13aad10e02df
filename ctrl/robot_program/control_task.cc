// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/control_task.h"

#include <algorithm>
#include <cmath>

#include "platform/core/usable.h"
#include "platform/robot/shapes.h"

namespace pipewright {
namespace {

/// Variances of a pose that nothing holds to what was seen.
constexpr double kNoBound = 1e6;

/// A twist read while a late cycle was under way is stamped after the cycle's instant.
constexpr Duration kAheadMost = std::chrono::milliseconds(10);

bool Valid(const BasePose& pose) {
  bool covariance =
      pose.covariance.diagonal().minCoeff() >= 0 && pose.covariance == pose.covariance.transpose();
  for (int i = 0; i < pose.covariance.size(); ++i) {
    covariance = covariance && Usable(pose.covariance(i));
  }
  return Usable({pose.x_m, pose.y_m, pose.phi_rad}) && covariance;
}

}  // namespace

bool Valid(const ControlTaskConfig& c) {
  return Valid(c.law) && Valid(c.localization) && c.base.Valid() && c.arm.Valid() &&
         Usable(c.joint_sigma_rad) && c.joint_sigma_rad >= 0 && Valid(c.start) &&
         c.state_timeout > Duration::zero() && Usable(c.state_timeout);
}

EnvelopeConfig EnvelopeOf(const RobotModel<kArmJoints>& robot, const ControlTaskConfig& config) {
  EnvelopeConfig e;
  e.period = FromSeconds(config.law.constraints.period_s);
  e.state_timeout = config.state_timeout;
  e.u_max << robot.base.speed_mps, robot.base.turn_radps,
      JointValues(robot, &ArmJoint::speed_radps);
  e.a_max << robot.base.acceleration_mps2, robot.base.turn_acceleration_radps2,
      JointValues(robot, &ArmJoint::acceleration_max_radps2);
  e.q_min = JointValues(robot, &ArmJoint::q_min_rad);
  e.q_max = JointValues(robot, &ArmJoint::q_max_rad);
  return e;
}

int CyclesPerArmCycle(const ControlTaskConfig& config) {
  const double cycles = 1e-3 * config.arm.cycle_ms / config.law.constraints.period_s;
  return cycles > 1 ? static_cast<int>(std::lround(std::min(cycles, 1000.0))) : 1;
}

ControlTask::ControlTask(const ControlTaskConfig& config, const RobotModel<kArmJoints>& robot)
    : status_(Valid(config) ? Status::kOk : Status::kOutOfRange),
      config_(Valid(config) ? config : ControlTaskConfig{}),
      base_(config_.base),
      arm_(config_.arm),
      filter_(config_.localization),
      uncertainty_(config_.joint_sigma_rad),
      law_(config_.law, robot, TracerUf7Shapes()),
      envelope_(EnvelopeOf(robot, config_)),
      arm_every_(CyclesPerArmCycle(config_)) {
  filter_.Reset(config_.start);
}

RobotState ControlTask::ReadState(Time now) {
  if (base_.has_odometer() && base_.twist_stamp() > last_twist_ &&
      base_.twist_stamp() <= now + kAheadMost) {
    last_twist_ = base_.twist_stamp();
    // A jump of the counters is counted by the odometry, which then goes by the twist.
    static_cast<void>(filter_.Step(base_.twist_stamp(), base_.twist().v_mps,
                                   base_.twist().omega_radps, base_.odometer().left_m,
                                   base_.odometer().right_m));
    const BasePose& by_wheels = filter_.odometry().pose();
    const BasePose corrected = filter_.pose();
    uncertainty_.Add(
        config_.scans_correct
            ? BaseBelief{by_wheels, corrected.phi_rad, corrected.covariance}
            : BaseBelief{by_wheels, by_wheels.phi_rad, kNoBound * Matrix3d::Identity()});
  }
  RobotState state;
  state.emergency_stop = base_.emergency_stop();
  if (!arm_.has_feedback() || !base_.has_odometer()) {
    return state;
  }
  state.stamp = arm_.feedback_stamp();
  const BasePose pose = PoseAt(state.stamp);
  state.q << pose.x_m, pose.y_m, pose.phi_rad, arm_.position_rad();
  state.u << base_.twist().v_mps, base_.twist().omega_radps, arm_.velocity_radps();
  state.valid = base_.ready() && arm_.ready() && now - last_twist_ <= config_.state_timeout &&
                !(config_.scans_correct && filter_.lost()) &&
                !(had_bus_trouble_ && now - bus_trouble_at_ < config_.state_timeout);
  return state;
}

BasePose ControlTask::PoseAt(Time stamp) const {
  return config_.scans_correct ? filter_.Extrapolate(stamp) : filter_.odometry().Extrapolate(stamp);
}

void ControlTask::Correct(const PoseFix& fix) {
  if (config_.scans_correct) {
    static_cast<void>(filter_.Correct(fix));
  }
}

PoseReport ControlTask::ReadPose() const {
  const BasePose by_wheels = filter_.odometry().Extrapolate(report_.state.stamp);
  return {.by_wheels = {by_wheels.x_m, by_wheels.y_m, by_wheels.phi_rad},
          .covariance = filter_.pose().covariance,
          .worst_covariance = filter_.worst_covariance(),
          .slip = filter_.slip(),
          .yaw_scale_slow = filter_.yaw_scale_slow(),
          .yaw_scale_fast = filter_.yaw_scale_fast(),
          .way_scale = filter_.way_scale(),
          .fixes = filter_.fixes(),
          .refused = filter_.refused(),
          .doubts = filter_.doubts(),
          .slips = filter_.slips(),
          .doubted = config_.scans_correct && filter_.doubted(),
          .lost = filter_.lost()};
}

ControlPhase ControlTask::Phase() const {
  if (base_.phase() == DriverPhase::kFault || arm_.phase() == DriverPhase::kFault) {
    return ControlPhase::kFault;
  }
  if (stopping_) {
    const bool stopped =
        base_.phase() == DriverPhase::kStopped && arm_.phase() == DriverPhase::kStopped;
    return stopped ? ControlPhase::kStopped : ControlPhase::kStopping;
  }
  return base_.ready() && arm_.ready() ? ControlPhase::kRunning : ControlPhase::kStarting;
}

const ControlReport& ControlTask::Step(Time now, const Scene& scene, const DistanceField& field,
                                       const Goal& goal, TxBatch& base_out, TxBatch& arm_out) {
  report_.now = now;
  if (bus_trouble_) {
    bus_trouble_ = false;
    had_bus_trouble_ = true;
    bus_trouble_at_ = now;
  }
  report_.state = ReadState(now);
  report_.pose = ReadPose();
  report_.state.valid = report_.state.valid && status_ == Status::kOk;
  const ControlOutput output =
      law_.Step({.state = report_.state,
                 .scene = scene,
                 .field = field,
                 .goal = goal,
                 .covariance_q = &uncertainty_.Since(scene, filter_.odometry())},
                now);
  report_.wanted = output.u;
  report_.progress = output.progress;
  report_.stats = output.stats;
  report_.sent = envelope_.Step(output.u, report_.state, now).u;
  law_.Sent(report_.sent, report_.stats);

  // A driver that is not ready, or is given what its frame cannot carry, sends zero.
  static_cast<void>(base_.Command(report_.sent(0), report_.sent(1)));
  base_.Step(now, base_out);
  if (--arm_wait_ <= 0) {
    arm_wait_ = arm_every_;
    static_cast<void>(arm_.Command(report_.sent.tail<kArmJoints>()));
    arm_.Step(now, arm_out);
  }
  report_.phase = Phase();
  report_.base_fault = base_.fault();
  report_.arm_fault = arm_.fault();
  return report_;
}

void ControlTask::Stop() {
  stopping_ = true;
  base_.Stop();
  arm_.Stop();
}

Status ControlTask::Rearm() {
  const Status status = envelope_.Rearm();
  if (status == Status::kOk) {
    stopping_ = false;
    base_.Reset();
    arm_.Reset();
  }
  return status;
}

}  // namespace pipewright
