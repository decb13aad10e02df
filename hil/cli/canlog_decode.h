// SPDX-License-Identifier: MIT
#pragma once

#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// `canlog decode`: prints every frame of the base and of the arm by the names of its signals.
/// @returns the exit code
int CanlogDecode(LogSet& log, const CanlogOptions& options);

}  // namespace pipewright::hil
