// SPDX-License-Identifier: MIT
#include "platform/linux/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>

namespace pipewright {
namespace {

constexpr std::size_t kBlockBytes = 4096;

/// Writes to the stack a block at a time, as deep as asked.
[[gnu::noinline]] void TouchStack(std::size_t bytes) {
  volatile char block[kBlockBytes];
  block[0] = 0;
  block[kBlockBytes - 1] = 0;
  if (bytes > kBlockBytes) {
    TouchStack(bytes - kBlockBytes);
  }
  block[1] = block[0];  // keeps the call above from becoming a jump
}

int PinTo(int cpu) {
  if (cpu < 0) {
    return 0;
  }
  if (cpu >= CPU_SETSIZE) {
    return EINVAL;
  }
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(cpu, &cpus);
  return pthread_setaffinity_np(pthread_self(), sizeof cpus, &cpus);
}

}  // namespace

RealtimeGrant MakeRealtime(const RealtimeRequest& request) {
  RealtimeGrant grant;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    grant.memory_error = errno;
  }
  TouchStack(std::min<std::size_t>(request.stack_bytes, 4 * 1024 * 1024));
  grant.affinity_error = PinTo(request.cpu);
  sched_param parameters{};
  parameters.sched_priority = request.priority;
  grant.scheduler_error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  return grant;
}

}  // namespace pipewright
