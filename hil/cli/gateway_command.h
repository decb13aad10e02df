// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace pipewright::hil {

/// Adds `gateway` to the command; what it returned is in *exit_code after parsing.
void AddGateway(CLI::App& app, int* exit_code);

}  // namespace pipewright::hil
