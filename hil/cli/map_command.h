// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace pipewright::hil {

/// Adds `map` to the command; what it returned is in *exit_code after parsing.
void AddMap(CLI::App& app, int* exit_code);

}  // namespace pipewright::hil
