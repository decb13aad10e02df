// SPDX-License-Identifier: MIT
#include "tests/timing/replay/replayed_cycle.h"

extern "C" {

void pipewright_replayed_cycle(pipewright::bench::RobotSide& robot,
                               pipewright::timing::ReplayPort& base,
                               pipewright::timing::ReplayPort& arm, pipewright::Time now) {
  pipewright::bench::RunControlCycle(robot, base, arm, now);
}

void pipewright_cycle_done() { asm volatile(""); }
}
