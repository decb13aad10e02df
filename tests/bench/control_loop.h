// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>

#include "plan/motion/motion_planner.h"
#include "platform/core/rng.h"
#include "tests/bench/robot_side.h"
#include "tests/ctrl/robot_program/device_bench.h"
#include "tests/plan/motion/cell.h"

namespace pipewright::bench {

/// RunControlCycle on the emulated buses. Not inlined: its name is what a profiler switches on and
/// off at.
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

  /// Cycles through `run` until every device is enabled and there is a goal; false: a device
  /// failed, or 10 s were not enough.
  template <typename Run>
  bool Start(const Run& run) {
    while (bench_.now() < kPatience) {
      if (!Cycle(run)) {
        return false;
      }
      if (robot_->task.report().phase == ControlPhase::kRunning && goals_ > 0) {
        return true;
      }
    }
    return false;
  }
  bool Start() { return Start(ControlCycle); }

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

  const LoopConfig& config() const { return config_; }
  const test::Cell& cell() const { return cell_; }
  const RobotSide& robot() const { return *robot_; }
  Time now() const { return bench_.now(); }
  int goals() const { return goals_; }
  int goals_reached() const { return goals_reached_; }

 private:
  static constexpr Time kPatience{std::chrono::seconds(10)};

  void Direct(const ControlReport& report);
  void Advance();

  LoopConfig config_;
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
