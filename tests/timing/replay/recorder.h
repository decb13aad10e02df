// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>

#include "tests/bench/control_loop.h"

namespace pipewright::timing {

/// Runs a loop that has not run yet until its devices are up and `cycles` more, and writes what
/// entered and left each cycle as a recording. @returns nullptr, or what went wrong
const char* Record(bench::ControlLoop& loop, std::uint64_t seed, int cycles, std::FILE* file);

}  // namespace pipewright::timing
