// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>

#include "tests/timing/replay/recording.h"

namespace pipewright::timing {

struct ReplayResult {
  int cycles = 0;
  int counted = 0;       ///< of them, those with the devices up
  int frames = 0;        ///< recorded as sent
  int different = 0;     ///< frames not the same byte for byte, or missing, or more
  int incomparable = 0;  ///< of them, those that differ in more than quantities: see LsbDifference
  std::int64_t largest_lsb = 0;
  int first_different = -1;      ///< cycle; -1: none
  std::int64_t field_bytes = 0;  ///< what the three distance fields hold
  int stack_bytes = 0;           ///< deepest during the cycles, below the function that runs them

  bool Within(std::int64_t lsb) const { return incomparable == 0 && largest_lsb <= lsb; }
};

/// Runs the control cycle anew on what a recording says it received, and compares what it sends.
///
/// sent: where the frames sent go as `candump -L` writes them, stamped with the cycle's time; may
/// be null. False: the recording is bad, see its problem(); or its configuration is refused, then
/// there is none.
bool Replay(RecordingReader& recording, std::FILE* sent, ReplayResult& result);

}  // namespace pipewright::timing
