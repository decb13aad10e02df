// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace pipewright {

struct RealtimeRequest {
  int priority = 80;                     ///< of SCHED_FIFO, 1 to 99
  int cpu = -1;                          ///< to stay on; -1: any
  std::size_t stack_bytes = 256 * 1024;  ///< touched now, so that no cycle faults it in
};

/// What could be had, and the system's error number for what could not (0: had). A desk machine
/// usually grants nothing of this: say so and go on; a robot should refuse to start.
struct RealtimeGrant {
  int memory_error = 0;     ///< mlockall, now and future
  int scheduler_error = 0;  ///< SCHED_FIFO
  int affinity_error = 0;   ///< cpu; 0 when none was asked for

  bool complete() const { return memory_error == 0 && scheduler_error == 0 && affinity_error == 0; }
};

/// Makes the calling thread a real-time one and locks the process's memory. Call once, at start.
RealtimeGrant MakeRealtime(const RealtimeRequest& request);

}  // namespace pipewright
