// SPDX-License-Identifier: MIT
#pragma once

#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// `canlog gaps`: prints what should not be in a log, as it is found, and how much of it there is.
/// @returns the exit code: a failure if there is any
int CanlogGaps(LogSet& log, const CanlogOptions& options);

}  // namespace pipewright::hil
