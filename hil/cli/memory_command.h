// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace pipewright::hil {

/// Adds `memory` to the command; what it returned is in *exit_code after parsing.
void AddMemory(CLI::App& app, int* exit_code);

}  // namespace pipewright::hil
