// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "ctrl/envelope/envelope.h"
#include "ctrl/robot_program/state_uncertainty.h"
#include "ctrl/whole_body/whole_body_controller.h"
#include "perception/localization/pose_filter.h"
#include "plan/goal.h"
#include "platform/drivers/arm_driver.h"
#include "platform/drivers/tracer_driver.h"
#include "platform/robot/model.h"

namespace pipewright {

struct ControlTaskConfig {
  WholeBodyConfig law;
  PoseFilterConfig localization;
  bool scans_correct = false;  ///< the base's pose; false: it is the wheels' alone
  TracerDriverConfig base;
  ArmDriverConfig arm;  ///< its cycle_ms, in whole periods of the law, is the arm's bus cycle
  /// Noise of a joint's reading and play of its gear. The arm's stated repeatability, 0.1 mm at 0.7
  /// m, is 1.4e-4.
  double joint_sigma_rad = 2e-4;
  BasePose start;  ///< where the robot stands when it is switched on
  Duration state_timeout = std::chrono::milliseconds(50);
};

/// Every field is a number that can be reckoned with, and those that go together fit.
bool Valid(const ControlTaskConfig& config);

/// Limits of the robot as the envelope wants them. period = that of the law.
EnvelopeConfig EnvelopeOf(const RobotModel<kArmJoints>& robot, const ControlTaskConfig& config);

/// Control cycles to one cycle of the arm's bus, at least 1: the law may run faster than the bus
/// carries seven commands, SYNC and seven answers.
int CyclesPerArmCycle(const ControlTaskConfig& config);

enum class ControlPhase : std::uint8_t {
  kStarting,  ///< devices are being found, configured and enabled
  kRunning,
  kStopping,  ///< asked to stop: on the way to rest, then devices are disabled
  kStopped,
  kFault,  ///< a device is at fault: zero is commanded; see base_fault and arm_fault
};

/// What is known of the base's pose besides state.q.
struct PoseReport {
  Vector3d by_wheels = Vector3d::Zero();         ///< (x, y, phi) that the wheels alone tell
  Matrix3d covariance = Matrix3d::Zero();        ///< of state.q's
  Matrix3d worst_covariance = Matrix3d::Zero();  ///< if wheels slipped as much as they can
  double slip = 1;                               ///< of the floor, over a usual one's
  double yaw_scale_slow = 1;                     ///< the base's turn over that of its wheels
  double yaw_scale_fast = 1;
  double way_scale = 1;
  std::uint64_t fixes = 0;    ///< taken
  std::uint64_t refused = 0;  ///< beyond the gate, or they fit nowhere
  std::uint64_t doubts = 0;   ///< so far
  std::uint64_t slips = 0;    ///< doubts that ended against the pose
  bool doubted = false;       ///< now: see PoseFilter
  bool lost = false;
};

/// What one cycle knew and did.
struct ControlReport {
  Time now{};
  ControlPhase phase = ControlPhase::kStarting;
  RobotState state;
  PoseReport pose;
  Controls wanted = Controls::Zero();  ///< by the law
  Controls sent = Controls::Zero();    ///< by the envelope
  GoalProgress progress;
  ControlStats stats;
  DeviceFault base_fault;
  DeviceFault arm_fault;
};

/// The first of the three tasks, and the only one that speaks to the buses:
///
///   frames -> drivers -> state -> law (3) -> envelope -> drivers -> frames
///
///   Frame frame;
///   while (base_port.Receive(frame)) task.OnBaseFrame(frame);
///   while (arm_port.Receive(frame)) task.OnArmFrame(frame);
///   task.Step(now, scene, field, goal, base_out, arm_out);     // once a period
///   ... send base_out and arm_out, in order
///
/// On a shared bus both handlers get every frame. No heap, no lock, no throw, no system call.
class ControlTask {
 public:
  ControlTask(const ControlTaskConfig& config, const RobotModel<kArmJoints>& robot);

  /// kOutOfRange: the configuration is not Valid; the task then only ever commands zero.
  Status status() const { return status_; }

  void OnBaseFrame(const can::Frame& frame) { base_.OnFrame(frame); }
  void OnArmFrame(const can::Frame& frame) { arm_.OnFrame(frame); }

  /// A bus was not read to its end, so that what is known may be old, or did not take what was
  /// sent: the next Step only brakes, and those after it for the state's timeout, longer than from
  /// one frame of the base to the next.
  void OnBusTrouble() { bus_trouble_ = true; }

  /// Where a scan found the base, before the Step that is to know it. One that is too old, or that
  /// the filter's gate refuses, moves nothing.
  void Correct(const PoseFix& fix);

  const ControlReport& Step(Time now, const Scene& scene, const DistanceField& field,
                            const Goal& goal, TxBatch& base_out, TxBatch& arm_out);

  /// To rest, then disabled: phase kStopped.
  void Stop();
  /// An operator's word after an emergency stop or a fault: forget it and start again.
  Status Rearm();

  const ControlReport& report() const { return report_; }
  const EnvelopeCounters& envelope_counters() const { return envelope_.counters(); }
  const TracerDriver& base() const { return base_; }
  const ArmDriver& arm() const { return arm_; }

 private:
  RobotState ReadState(Time now);
  BasePose PoseAt(Time stamp) const;
  PoseReport ReadPose() const;
  ControlPhase Phase() const;

  Status status_;
  ControlTaskConfig config_;  ///< the default where that given is not valid
  TracerDriver base_;
  ArmDriver arm_;
  PoseFilter filter_;
  StateUncertainty uncertainty_;
  WholeBodyController law_;
  Envelope envelope_;
  Time last_twist_{};
  int arm_every_;     ///< cycles
  int arm_wait_ = 0;  ///< cycles until the arm's next
  bool stopping_ = false;
  bool bus_trouble_ = false;
  bool had_bus_trouble_ = false;
  Time bus_trouble_at_{};
  ControlReport report_;
};

}  // namespace pipewright
