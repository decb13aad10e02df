// SPDX-License-Identifier: MIT
// F16: cycles that would take memory.
#include "hil/cli/heap_watch.h"
#include "tests/bench/faults/fault_rig.h"
#include "tests/bench/faults/rows.h"

namespace pipewright::bench {

using std::chrono_literals::operator""ms;

Tally CyclesThatAllocate(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  FaultRig rig(seed);
  while (rig.cycles() < n) {
    if (!rig.Ready(tally)) {
      return tally;
    }
    rig.arm().Lose(rig.rng().Index(60), [](const can::Frame&) { return true; });
    for (int i = 0; i < 20; ++i) {
      rig.base().Replay(rig.rng());
    }
    rig.For(200ms);
  }
  tally.Add(Outcome::kMasked, rig.cycles() - rig.cycles_that_allocate());
  tally.Add(Outcome::kWrong, rig.cycles_that_allocate());
  tally.Note(
      hil::HeapWatch::Counting()
          ? "heap; locks and allocators: scripts/check_heap_free.sh, by the archives' symbols"
          : "nothing was counted: a sanitizer has the heap");
  return tally;
}

}  // namespace pipewright::bench
