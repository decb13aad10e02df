// SPDX-License-Identifier: MIT
#pragma once

#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// `canlog export`: prints the signals of base and arm as one table, a column a signal.
/// @returns the exit code
int CanlogExport(LogSet& log, const CanlogOptions& options);

}  // namespace pipewright::hil
