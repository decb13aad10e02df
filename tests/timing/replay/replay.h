// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>

#include "tests/timing/replay/recording.h"
#include "tests/timing/replay/replayed_cycle.h"

namespace pipewright::timing {

inline constexpr int kManyRows = 120;

struct ReplayResult {
  int cycles = 0;
  int counted = 0;       ///< of them, those that the recording says count
  int many_rows = 0;     ///< of those, with kManyRows rows of the QP or more
  int frames = 0;        ///< recorded as sent
  int different = 0;     ///< frames not the same byte for byte, or missing, or more
  int incomparable = 0;  ///< of them, those that differ in more than quantities: see LsbDifference
  std::int64_t largest_lsb = 0;
  int first_different = -1;                                      ///< cycle; -1: none
  int robot_bytes = static_cast<int>(sizeof(bench::RobotSide));  ///< of the whole control path
  std::int64_t field_bytes = 0;  ///< what the three distance fields hold
  int stack_bytes = 0;           ///< deepest during the cycles, below the function that runs them

  bool Within(std::int64_t lsb) const { return incomparable == 0 && largest_lsb <= lsb; }
};

/// Runs the control cycle anew on what a recording says it received, and compares what it sends.
/// Its memory is in it but for the distance fields; for one run.
class Replay {
 public:
  /// sent: where the frames sent go as `candump -L` writes them, stamped with the cycle's time; may
  /// be null. False: the recording is bad, see its problem(); or its configuration is refused, then
  /// there is none.
  bool Run(RecordingReader& recording, std::FILE* sent, ReplayResult& result);

 private:
  bool Start(RecordingReader& recording);
  void RunCycle();

  std::optional<bench::RobotSide> robot_;
  RecordedCycle cycle_;
  ReplayPort base_;
  ReplayPort arm_;
};

}  // namespace pipewright::timing
