// SPDX-License-Identifier: MIT
#pragma once

#include "hil/cli/canlog_input.h"

namespace pipewright::hil {

/// `canlog diff`: prints where two logs part, id by id, and how their times differ.
/// @returns the exit code: a failure if they differ in more than time
int CanlogDiff(const CanlogOptions& options);

}  // namespace pipewright::hil
