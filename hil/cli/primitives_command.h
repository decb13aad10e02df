// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace pipewright::hil {

/// Adds `pipewright primitives`. *exit_code is set when the command has run.
void AddPrimitives(CLI::App& app, int* exit_code);

}  // namespace pipewright::hil
