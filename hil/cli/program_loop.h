// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "ctrl/robot_program/robot_program.h"
#include "hil/devices/port.h"
#include "platform/core/depth_frame.h"

namespace pipewright::hil {

/// The other end of a robot program's wires in virtual time, emulated or recorded, and who is told
/// what the program did.
class ProgramPeer {
 public:
  virtual ~ProgramPeer() = default;

  /// Brings every CAN frame up to `now` to the robot's ports.
  virtual void AdvanceTo(Time now) = 0;
  virtual Port& base() = 0;
  virtual Port& arm() = 0;  ///< the same as base(): one bus for both
  /// Fills `frame` if the camera has one to give at `now`.
  virtual bool See(Time now, DepthFrame& frame) = 0;
  /// Whether the program is to be stopped from outside; asked after each control cycle.
  virtual bool StopAsked(Time now) = 0;

  /// After each control cycle. `took` and `allocations` are of the cycle alone.
  virtual void OnControl(const ControlReport& report, std::chrono::nanoseconds took,
                         std::uint64_t allocations) = 0;
  /// After each planning step, that is when there is a new decision.
  virtual void OnPlan(Time now, const PlanningTask& planning, std::chrono::nanoseconds took) = 0;
};

/// Runs the three tasks of a robot program on one thread in virtual time. This is the only schedule
/// of such runs: what it does is a function of what the peer gives. At each tick, in this order:
///
///   the buses       up to the tick
///   Map(frame)      if the camera gives one
///   Plan(now)       each kPlanPeriod
///   Control(now)    each control period, a whole number of ticks
class ProgramLoop {
 public:
  static constexpr Duration kTick = std::chrono::milliseconds(1);
  static constexpr Duration kPlanPeriod = std::chrono::milliseconds(50);

  /// Both must outlive this.
  ProgramLoop(RobotProgram& program, Duration control_period, ProgramPeer& peer);

  /// @param now  one kTick after the call before
  void Tick(Time now);

 private:
  void Plan(Time now);
  void Control(Time now);

  RobotProgram& program_;
  Duration control_period_;
  ProgramPeer& peer_;
  std::unique_ptr<DepthFrame> frame_;
  Time next_plan_{};
  Time next_cycle_{};
};

}  // namespace pipewright::hil
