// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace pipewright::hil {

/// Adds `canlog` to the command; what it returned is in *exit_code after parsing.
void AddCanlog(CLI::App& app, int* exit_code);

}  // namespace pipewright::hil
