// SPDX-License-Identifier: MIT
#include "ctrl/daemon/realtime_check.h"

#include <fmt/format.h>

#include <cstring>

#include "platform/linux/task_thread.h"

namespace pipewright {
namespace {

struct Asked {
  RealtimeRequest request;
  RealtimeGrant grant;
};

}  // namespace

RealtimeGrant TryRealtime(const RealtimeRequest& request) {
  Asked asked{request, {}};
  TaskThread thread;
  const auto ask = [](void* context) {
    auto* self = static_cast<Asked*>(context);
    self->grant = MakeRealtime(self->request);
  };
  if (thread.Start("pw-realtime", ask, &asked) != Status::kOk) {
    return {.memory_error = EAGAIN, .scheduler_error = EAGAIN, .affinity_error = EAGAIN};
  }
  thread.Join();
  return asked.grant;
}

std::vector<std::string> RefusalWords(const RealtimeGrant& grant, const RealtimeRequest& request) {
  std::vector<std::string> words;
  if (grant.memory_error != 0) {
    words.push_back(
        fmt::format("locked memory was refused: {}. Grant it with LimitMEMLOCK=infinity or "
                    "AmbientCapabilities=CAP_IPC_LOCK in the unit",
                    std::strerror(grant.memory_error)));
  }
  if (grant.scheduler_error != 0) {
    words.push_back(
        fmt::format("SCHED_FIFO at priority {} was refused: {}. Grant it with LimitRTPRIO={} or "
                    "AmbientCapabilities=CAP_SYS_NICE in the unit",
                    request.priority, std::strerror(grant.scheduler_error), request.priority));
  }
  if (grant.affinity_error != 0) {
    words.push_back(fmt::format(
        "processor {} was refused: {}. Set realtime.cpu to one that this machine has and that "
        "AllowedCPUs= and CPUAffinity= of the unit let it use",
        request.cpu, std::strerror(grant.affinity_error)));
  }
  return words;
}

}  // namespace pipewright
