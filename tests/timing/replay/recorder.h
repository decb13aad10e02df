// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>

#include "tests/bench/control_loop.h"

namespace pipewright::timing {

/// Runs a loop that has not run yet until its devices are up, `skip` cycles more and then `cycles`
/// that are counted, and writes what entered and left each of all these as a recording.
/// @returns nullptr, or what went wrong
const char* Record(bench::ControlLoop& loop, std::uint64_t seed, int skip, int cycles,
                   std::FILE* file);

}  // namespace pipewright::timing
