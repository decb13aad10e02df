// SPDX-License-Identifier: MIT
#pragma once

#include "hil/canlog/log_stats.h"
#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// `canlog stats`: reads the log to its end and prints figures of all, each channel and each id.
/// @returns the exit code
int CanlogStats(LogSet& log, const CanlogOptions& options);

}  // namespace pipewright::hil
