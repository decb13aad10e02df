// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>

#include "ctrl/robot_program/robot_program.h"
#include "platform/core/latest.h"
#include "platform/linux/realtime.h"
#include "platform/linux/task_thread.h"

namespace pipewright {

struct RobotThreadsConfig {
  Duration control_period = std::chrono::milliseconds(10);
  Duration plan_period = std::chrono::milliseconds(50);
  Duration frame_poll = std::chrono::milliseconds(2);  ///< how often mapping looks for a frame
  /// The tasks are told the time since then, on the clock of Now(). The stamps of the frames that
  /// the buses give, and of the depth frames, must count from the same instant.
  Time epoch{};
  bool realtime = true;  ///< ask for SCHED_FIFO and locked memory; without them the run goes on
  RealtimeRequest request;

  bool Valid() const {
    return control_period > Duration::zero() && plan_period > Duration::zero() &&
           frame_poll > Duration::zero();
  }
};

/// Is told after each step what it did, on the thread that did it. Must not wait.
class ThreadObserver {
 public:
  virtual void OnControl(const ControlReport& report, Duration took) = 0;
  virtual void OnMap(const MappingTask& mapping, Duration took) = 0;
  virtual void OnPlan(Time now, const PlanningTask& planning, bool camera_lost, Duration took) = 0;

 protected:
  ~ThreadObserver() = default;
};

/// What the control thread has seen of its clock.
struct CycleStats {
  std::uint64_t cycles = 0;
  std::uint64_t missed = 0;  ///< periods that passed without a cycle
  Duration worst_latency{};  ///< latest that a cycle began after its instant
};

/// Turns that each task's loop has made. One whose count stands still does not answer: it hangs in
/// a step, or is not given the processor. A task that waits for its input turns, too.
struct TaskTurns {
  std::uint64_t control = 0;
  std::uint64_t mapping = 0;
  std::uint64_t planning = 0;
};

/// Runs a RobotProgram's three tasks on three threads and the machine's clock:
///
///   control   each control_period, SCHED_FIFO where it is granted
///   mapping   each frame put into frames(); one that is overtaken by a newer is lost on purpose
///   planning  each plan_period; a plan that takes longer delays the next
///
///   RobotThreads threads(program, config, &observer);
///   if (threads.Start(base_bus, arm_bus) != Status::kOk) ...
///   threads.frames().Back() = frame; threads.frames().Publish();   // one thread: the camera's
///   threads.Stop(5s);
///
/// No heap, and no thread outlives it.
class RobotThreads {
 public:
  /// `program`, and the observer if any, must outlive this.
  RobotThreads(RobotProgram& program, const RobotThreadsConfig& config,
               ThreadObserver* observer = nullptr)
      : program_(program), config_(config), observer_(observer) {}
  ~RobotThreads() { Stop(Duration::zero()); }

  /// The buses must outlive the threads and are used by the control thread alone; one may serve as
  /// both. kOutOfRange: the configuration is not valid. kUnavailable: the system gives no thread.
  /// kFull: it runs already.
  template <can::Bus Base, can::Bus Arm>
  Status Start(Base& base, Arm& arm) {
    base_ = &base;
    arm_ = &arm;
    control_ = [](RobotThreads& self, Time now) -> const ControlReport& {
      return self.program_.Control(*static_cast<Base*>(self.base_), *static_cast<Arm*>(self.arm_),
                                   now);
    };
    return StartThreads();
  }

  /// Asks the program to stop, waits at most `patience` for the robot to be at rest and disabled,
  /// ends the threads. @returns whether the robot was
  bool Stop(Duration patience);

  /// What Stop() does, in pieces that do not wait: asks the threads to return, tells whether all
  /// have. Stop() then returns at once.
  void Quit() { quit_ = true; }
  bool returned() const { return running_.load(std::memory_order_acquire) == 0; }

  /// The camera's side of the mailbox.
  Latest<DepthFrame>& frames() { return frames_; }

  // Any thread.
  ControlPhase phase() const { return phase_.load(std::memory_order_relaxed); }
  CycleStats cycles() const;
  TaskTurns turns() const;
  /// What the system granted; settled before Start() returns.
  const RealtimeGrant& grant() const { return grant_; }

 private:
  Status StartThreads();
  void ControlLoop();
  void MappingLoop();
  void PlanningLoop();
  Time SinceEpoch(Time now) const { return Time{now - config_.epoch}; }
  bool quit() const { return quit_.load(std::memory_order_relaxed); }

  RobotProgram& program_;
  RobotThreadsConfig config_;
  ThreadObserver* observer_;
  void* base_ = nullptr;
  void* arm_ = nullptr;
  const ControlReport& (*control_)(RobotThreads& self, Time now) = nullptr;
  Latest<DepthFrame> frames_;
  RealtimeGrant grant_;
  std::atomic<bool> granted_ = false;
  std::atomic<bool> quit_ = false;
  std::atomic<int> running_ = 0;
  std::atomic<ControlPhase> phase_ = ControlPhase::kStarting;
  std::atomic<std::uint64_t> cycles_ = 0;
  std::atomic<std::uint64_t> mapping_turns_ = 0;
  std::atomic<std::uint64_t> planning_turns_ = 0;
  std::atomic<std::uint64_t> missed_ = 0;
  std::atomic<Duration::rep> worst_latency_ns_ = 0;
  TaskThread control_thread_;
  TaskThread mapping_thread_;
  TaskThread planning_thread_;
};

}  // namespace pipewright
