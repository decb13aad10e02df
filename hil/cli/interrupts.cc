// SPDX-License-Identifier: MIT
#include "hil/cli/interrupts.h"

#include <atomic>
#include <csignal>

namespace pipewright::hil {
namespace {

std::atomic<bool> interrupted = false;

void OnInterrupt(int) { interrupted = true; }

}  // namespace

void CatchInterrupts() {
  std::signal(SIGINT, OnInterrupt);
  std::signal(SIGTERM, OnInterrupt);
}

bool Interrupted() { return interrupted; }

}  // namespace pipewright::hil
