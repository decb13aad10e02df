// SPDX-License-Identifier: MIT
#pragma once

#include "hil/cli/run_figures.h"

namespace pipewright::hil {

/// Adds one control cycle to the figures that only the emulator can know: how far the odometry is
/// from the truth, whether a joint passed its limit, how long coverage took.
void WatchTruth(const ControlReport& report, const Emulator& emulator, RunFigures& figures);

}  // namespace pipewright::hil
