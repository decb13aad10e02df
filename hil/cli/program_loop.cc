// SPDX-License-Identifier: MIT
#include "hil/cli/program_loop.h"

#include "hil/cli/heap_watch.h"

namespace pipewright::hil {
namespace {

using WallClock = std::chrono::steady_clock;

}  // namespace

ProgramLoop::ProgramLoop(RobotProgram& program, Duration control_period, ProgramPeer& peer)
    : program_(program),
      control_period_(control_period),
      peer_(peer),
      frame_(std::make_unique<DepthFrame>()) {}

void ProgramLoop::Plan(Time now) {
  const int steps = program_.planning().output().plan_steps;
  const WallClock::time_point start = WallClock::now();
  const MissionOutput& mission = program_.Plan(now);
  if (mission.planned && mission.plan_steps != steps) {
    peer_.OnPlan(now, program_.planning(), WallClock::now() - start);
  }
}

void ProgramLoop::Control(Time now) {
  const WallClock::time_point start = WallClock::now();
  const HeapWatch heap;
  const ControlReport& report = program_.Control(peer_.base(), peer_.arm(), now);
  const std::uint64_t allocations = heap.allocations();
  peer_.OnControl(report, WallClock::now() - start, allocations);
  if (peer_.StopAsked(now)) {
    program_.RequestStop();
  }
}

void ProgramLoop::Tick(Time now) {
  peer_.AdvanceTo(now);
  if (peer_.See(now, *frame_)) {
    // A frame that comes before the robot knows where it is, is dropped and counted by the task.
    static_cast<void>(program_.Map(*frame_));
  }
  if (now >= next_plan_) {
    next_plan_ += kPlanPeriod;
    Plan(now);
  }
  if (now >= next_cycle_) {
    next_cycle_ += control_period_;
    Control(now);
  }
}

}  // namespace pipewright::hil
