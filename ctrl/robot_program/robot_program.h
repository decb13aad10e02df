// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>

#include "ctrl/robot_program/bus_cycle.h"
#include "ctrl/robot_program/control_task.h"
#include "ctrl/robot_program/mapping_task.h"
#include "ctrl/robot_program/planning_task.h"
#include "platform/can/bus.h"
#include "platform/core/latest.h"

namespace pipewright {

struct RobotProgramConfig {
  ControlTaskConfig control;
  MappingConfig mapping;
  MissionConfig mission;
  ArmVector start_joints_rad = ArmVector::Zero();     ///< for the start bubble, before any feedback
  Duration camera_timeout = std::chrono::seconds(1);  ///< without a frame that could be used
};

/// The program that runs on the robot: three tasks, each its own memory, that meet only in
/// Latest<T>. Each may have its thread, or all three one; a virtual run is a function of its
/// inputs.
///
///   control task   Control(base bus, arm bus, now)    every period
///   mapping task   Map(frame)                         every depth frame
///   planning task  Plan(now)                          a few times a second; may take long
class RobotProgram {
 public:
  RobotProgram(const RobotProgramConfig& config, const RobotModel<kArmJoints>& robot);

  Status status() const { return control_.status(); }

  /// Control thread: reads both buses, steps, sends. One port may serve as both.
  template <can::Bus Base, can::Bus Arm>
  const ControlReport& Control(Base& base, Arm& arm, Time now);

  /// Mapping thread.
  Status Map(const DepthFrame& frame);

  /// Mapping thread: takes into the map what the planner gave up. Map() does so too.
  void TakeResidual();

  /// Planning thread. After the mission has ended it asks the control task to stop. A camera that
  /// stays silent is a device fault like any other.
  const MissionOutput& Plan(Time now);
  bool camera_lost() const { return camera_lost_; }

  /// Any thread: bring the robot to rest and disable it.
  void RequestStop() { stop_requested_.store(true, std::memory_order_relaxed); }

  const ControlTask& control() const { return control_; }
  const MappingTask& mapping() const { return mapping_; }
  const PlanningTask& planning() const { return planning_; }

  /// What the buses did not take or were not asked for. The cycle after one brakes.
  const BusCounters& bus_counters() const { return bus_counters_; }

 private:
  const ControlReport& StepControl(Time now);

  ControlTask control_;
  MappingTask mapping_;
  PlanningTask planning_;

  Latest<Surrounding> surrounding_;  // mapping -> control
  Latest<MapSnapshot> snapshot_;     // mapping -> planning
  Latest<Goal> goal_;                // planning -> control
  Latest<ResidualVoxels> residual_;  // planning -> mapping
  Latest<PoseFix> fix_;              // mapping -> control
  Latest<Motion> motion_;            // control -> mapping
  Latest<ControlReport> report_;     // control -> planning
  StateHistory states_;              // control's own
  TxBatch base_out_;
  TxBatch arm_out_;
  std::atomic<bool> stop_requested_ = false;
  bool stopping_ = false;
  std::uint32_t goal_id_ = 0;
  Duration camera_timeout_;
  Time camera_seen_{};  // planning's: when the map last changed, or no frame could be used
  Time map_stamp_{};
  bool camera_lost_ = false;
  BusCounters bus_counters_;
};

template <can::Bus Base, can::Bus Arm>
const ControlReport& RobotProgram::Control(Base& base, Arm& arm, Time now) {
  ReceiveFrames(base, arm, control_, bus_counters_);
  const ControlReport& report = StepControl(now);
  SendFrames(base, base_out_, control_, bus_counters_);
  SendFrames(arm, arm_out_, control_, bus_counters_);
  return report;
}

}  // namespace pipewright
