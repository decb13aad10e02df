// SPDX-License-Identifier: MIT
#pragma once

#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// `canlog dbc`: prints the frames of base and arm as a DBC file. @returns the exit code
int CanlogDbc(LogSet& log, const CanlogOptions& options);

}  // namespace pipewright::hil
