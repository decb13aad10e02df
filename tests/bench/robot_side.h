// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/robot_program/bus_cycle.h"
#include "ctrl/robot_program/control_task.h"
#include "ctrl/robot_program/perceived.h"
#include "platform/can/bus.h"
#include "platform/core/latest.h"
#include "platform/robot/state_history.h"
#include "platform/robot/uf7.h"

namespace pipewright::bench {

/// What a run tells its control task; the rest is the defaults of ControlTaskConfig.
struct LoopConfig {
  double period_s = 0.01;
  int arm_cycle_ms = 10;
  double x_m = 0;  ///< where the base starts
  double y_m = 0;
  double phi_rad = 0;
  double reached = 0.02;  ///< m and 1: the last centimetre is slow, and nothing new
};

ControlTaskConfig TaskConfig(const LoopConfig& config);

/// What RobotProgram's control thread holds: the task, and the slots in which it meets the other
/// two, of which the surrounding is written once and the goal whenever there is a new one.
struct RobotSide {
  RobotSide(const ControlTaskConfig& config, const MapConfig& map)
      : task(config, TracerUf7()), surrounding(Surrounding(map)) {}

  ControlTask task;
  Latest<Surrounding> surrounding;
  Latest<Goal> goal;
  Latest<StateHistory> history;
  Latest<ControlReport> report;
  StateHistory states;
  TxBatch base_out;
  TxBatch arm_out;
  BusCounters buses;
};

/// One whole control cycle, as RobotProgram::Control has it on two buses: every received frame
/// decoded, the surrounding and the goal read, the task's step (state, rows, QP, envelope, frames),
/// the state and the report handed on, the frames sent.
template <can::Bus Base, can::Bus Arm>
const ControlReport& RunControlCycle(RobotSide& robot, Base& base, Arm& arm, Time now) {
  ReceiveFrames(base, arm, robot.task, robot.buses);
  robot.base_out.clear();
  robot.arm_out.clear();
  const Surrounding& around = robot.surrounding.Read();
  const ControlReport& report = robot.task.Step(now, around.scene, around.field, robot.goal.Read(),
                                                robot.base_out, robot.arm_out);
  robot.states.Add(report.state);
  robot.history.Write(robot.states);
  robot.report.Write(report);
  SendFrames(base, robot.base_out, robot.task, robot.buses);
  SendFrames(arm, robot.arm_out, robot.task, robot.buses);
  return report;
}

}  // namespace pipewright::bench
