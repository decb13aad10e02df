// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>

#include "ctrl/robot_program/control_task.h"
#include "ctrl/robot_program/perceived.h"
#include "plan/motion/motion_planner.h"
#include "platform/core/latest.h"
#include "platform/core/rng.h"
#include "platform/robot/state_history.h"
#include "tests/ctrl/robot_program/device_bench.h"
#include "tests/plan/motion/cell.h"

namespace pipewright::bench {

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
  int send_failures = 0;
};

/// One whole control cycle, as RobotProgram::Control has it on two buses: every received frame
/// decoded, the surrounding and the goal read, the task's step (state, rows, QP, envelope, frames),
/// the state and the report handed on, the frames sent. Not inlined: its name is what a profiler
/// switches on and off at.
[[gnu::noinline]] const ControlReport& ControlCycle(RobotSide& robot, can::LoopbackBus::Port& base,
                                                    can::LoopbackBus::Port& arm, Time now);

/// Goals that keep the robot near things. By turns: a reachable sensor pose with a planned way
/// there, and from where that ends a set point further along the sensor's axis without a way, so
/// that the law leans on whatever is ahead. Where no way leads out again, back to where the last
/// one ended, unchecked: the rows hold what they hold.
class GoalMaker {
 public:
  GoalMaker(const test::Cell& cell, std::uint64_t seed) : cell_(cell), rng_(seed) {}

  const Goal& Next(const Configuration& from);

 private:
  bool TryWay(const Configuration& from);
  void Push(const Configuration& from);
  void GoBack(const Configuration& from);

  const test::Cell& cell_;
  Rng rng_;
  MotionPlanner planner_;
  Goal goal_;
  Configuration free_ = test::Cell::Start();  ///< where the last planned way ended
  bool has_way_ = false;                      ///< the goal in hand was planned
};

/// The robot among pipes and walls on its emulated devices, in virtual time. The cell is known from
/// the start and stays so; where the robot is in it, only its odometry says.
class ControlLoop {
 public:
  /// rate_hz: whole milliseconds, 1 to 20. stopwatch: WholeBodyConfig's, may be null.
  ControlLoop(double rate_hz, std::uint64_t seed, std::int64_t (*stopwatch)());

  /// Cycles until every device is enabled; false: a device failed, or 10 s were not enough.
  bool Start();

  /// One cycle through `run`, which is to call ControlCycle with what it is given; then the world
  /// goes on to the next. False: a device is at fault.
  template <typename Run>
  bool Cycle(const Run& run) {
    const ControlReport& report = run(*robot_, bench_.base(), bench_.arm(), bench_.now());
    const bool well = report.phase != ControlPhase::kFault;
    Direct(report);
    Advance();
    return well;
  }

  const RobotSide& robot() const { return *robot_; }
  Time now() const { return bench_.now(); }
  int goals() const { return goals_; }
  int goals_reached() const { return goals_reached_; }

 private:
  void Direct(const ControlReport& report);
  void Advance();

  test::Cell cell_;
  test::DeviceBench bench_;
  std::unique_ptr<RobotSide> robot_;
  std::unique_ptr<GoalMaker> maker_;
  int ticks_;  ///< a cycle
  Time goal_end_{};
  int goals_ = 0;
  int goals_reached_ = 0;
};

}  // namespace pipewright::bench
