// SPDX-License-Identifier: MIT
#include "platform/linux/stop_signals.h"

#include <pthread.h>
#include <signal.h>

#include <ctime>

namespace pipewright {
namespace {

sigset_t Set() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  return set;
}

}  // namespace

void StopSignals::Block() {
  const sigset_t set = Set();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

bool StopSignals::Pending() {
  const sigset_t set = Set();
  const timespec at_once{};
  return sigtimedwait(&set, nullptr, &at_once) > 0;
}

}  // namespace pipewright
