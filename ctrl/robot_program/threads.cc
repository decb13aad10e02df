// SPDX-License-Identifier: MIT
#include "ctrl/robot_program/threads.h"

#include "platform/linux/clock.h"

namespace pipewright {
namespace {

constexpr Duration kPoll = std::chrono::milliseconds(1);
constexpr int kThreads = 3;

}  // namespace

Status RobotThreads::StartThreads() {
  if (!config_.Valid()) {
    return Status::kOutOfRange;
  }
  if (control_thread_.started()) {
    return Status::kFull;
  }
  quit_ = false;
  granted_ = false;
  phase_ = ControlPhase::kStarting;
  const auto control = [](void* self) { static_cast<RobotThreads*>(self)->ControlLoop(); };
  const auto mapping = [](void* self) { static_cast<RobotThreads*>(self)->MappingLoop(); };
  const auto planning = [](void* self) { static_cast<RobotThreads*>(self)->PlanningLoop(); };
  running_ = kThreads;
  // Those that may be late first: the control task finds them there.
  if (mapping_thread_.Start("pw-mapping", mapping, this) != Status::kOk ||
      planning_thread_.Start("pw-planning", planning, this) != Status::kOk ||
      control_thread_.Start("pw-control", control, this) != Status::kOk) {
    Stop(Duration::zero());
    return Status::kUnavailable;
  }
  while (!granted_.load(std::memory_order_acquire)) {
    SleepUntil(Now() + kPoll);
  }
  return Status::kOk;
}

bool RobotThreads::Stop(Duration patience) {
  program_.RequestStop();
  const Time deadline = Now() + patience;
  while (control_thread_.started() && phase() != ControlPhase::kStopped && Now() < deadline) {
    SleepUntil(Now() + kPoll);
  }
  quit_ = true;
  control_thread_.Join();
  planning_thread_.Join();
  mapping_thread_.Join();
  return phase() == ControlPhase::kStopped;
}

TaskTurns RobotThreads::turns() const {
  return {.control = cycles_.load(std::memory_order_relaxed),
          .mapping = mapping_turns_.load(std::memory_order_relaxed),
          .planning = planning_turns_.load(std::memory_order_relaxed)};
}

CycleStats RobotThreads::cycles() const {
  return {.cycles = cycles_.load(std::memory_order_relaxed),
          .missed = missed_.load(std::memory_order_relaxed),
          .worst_latency = Duration(worst_latency_ns_.load(std::memory_order_relaxed))};
}

void RobotThreads::ControlLoop() {
  grant_ = config_.realtime ? MakeRealtime(config_.request) : RealtimeGrant{};
  granted_.store(true, std::memory_order_release);
  PeriodicTimer timer(config_.control_period);
  while (!quit()) {
    const Time start = timer.Wait();
    const ControlReport& report = control_(*this, SinceEpoch(start));
    phase_.store(report.phase, std::memory_order_relaxed);
    cycles_.fetch_add(1, std::memory_order_relaxed);
    missed_.store(timer.missed(), std::memory_order_relaxed);
    worst_latency_ns_.store(timer.worst_latency().count(), std::memory_order_relaxed);
    if (observer_ != nullptr) {
      observer_->OnControl(report, Now() - start);
    }
  }
  running_.fetch_sub(1, std::memory_order_release);
}

void RobotThreads::MappingLoop() {
  while (!quit()) {
    mapping_turns_.fetch_add(1, std::memory_order_relaxed);
    if (!frames_.HasNew()) {
      SleepUntil(Now() + config_.frame_poll);
      continue;
    }
    const Time start = Now();
    // A frame whose pose is not known, or that makes no sense, is dropped and counted by the task.
    static_cast<void>(program_.Map(frames_.Read()));
    if (observer_ != nullptr) {
      observer_->OnMap(program_.mapping(), Now() - start);
    }
  }
  running_.fetch_sub(1, std::memory_order_release);
}

void RobotThreads::PlanningLoop() {
  PeriodicTimer timer(config_.plan_period);
  while (!quit()) {
    const Time start = timer.Wait();
    planning_turns_.fetch_add(1, std::memory_order_relaxed);
    program_.Plan(SinceEpoch(start));
    if (observer_ != nullptr) {
      observer_->OnPlan(SinceEpoch(start), program_.planning(), program_.camera_lost(),
                        Now() - start);
    }
  }
  running_.fetch_sub(1, std::memory_order_release);
}

}  // namespace pipewright
