// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace pipewright::hil {

/// Adds status, start, stop, estop and rearm: an operator's words to pipewrightd.
void AddService(CLI::App& app, int* exit_code);

}  // namespace pipewright::hil
