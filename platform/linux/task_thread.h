// SPDX-License-Identifier: MIT
#pragma once

#include <pthread.h>

#include "platform/core/status.h"

namespace pipewright {

/// One thread that is always joined: by Join(), or at the latest when this goes out of scope. The
/// work it does must end by itself; tell it to before joining.
///
///   TaskThread thread;
///   if (thread.Start("control", &Loop, &context) != Status::kOk) ...
///   stop = true;
///   thread.Join();
class TaskThread {
 public:
  using Work = void (*)(void* context);

  TaskThread() = default;
  ~TaskThread() { Join(); }
  TaskThread(const TaskThread&) = delete;
  TaskThread& operator=(const TaskThread&) = delete;

  /// Runs work(context) on a thread of its own, called `name` (15 characters count) where threads
  /// are listed. kUnavailable: the system gives no thread. kFull: one runs here already.
  Status Start(const char* name, Work work, void* context);

  /// Waits until the work has returned. Nothing to wait for: returns at once.
  void Join();

  bool started() const { return started_; }

 private:
  static void* Run(void* self);

  Work work_ = nullptr;
  void* context_ = nullptr;
  pthread_t thread_{};
  bool started_ = false;
};

}  // namespace pipewright
