// SPDX-License-Identifier: MIT
#pragma once

#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// `canlog load`: prints the load of each channel over time. @returns the exit code
int CanlogLoad(LogSet& log, const CanlogOptions& options);

}  // namespace pipewright::hil
