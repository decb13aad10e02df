// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/robot_program/threads.h"
#include "platform/core/time.h"

namespace pipewright {

/// How long each task may go without a turn of its loop.
struct TaskBounds {
  Duration control = std::chrono::seconds(1);
  Duration mapping = std::chrono::seconds(1);
  Duration planning = std::chrono::seconds(30);  ///< a plan may take long
};

/// Whether the three tasks answer. Pure: told their turns and the time. No heap.
class TaskWatch {
 public:
  explicit TaskWatch(const TaskBounds& bounds) : bounds_(bounds) {}

  /// From now on: none has turned yet, each has its whole bound.
  void Start(Time now);

  void See(const TaskTurns& turns, Time now);

  /// The first task that has been silent for longer than its bound, by its name; else nullptr.
  const char* Silent(Time now) const;

  /// Whether the watchdog may be stroked: control and mapping have turned since it last was, and no
  /// task is silent.
  bool MayStroke(Time now) const;
  void Stroked() { stroked_ = turns_; }

 private:
  TaskBounds bounds_;
  TaskTurns turns_;
  TaskTurns stroked_;
  Time control_at_{};
  Time mapping_at_{};
  Time planning_at_{};
};

}  // namespace pipewright
