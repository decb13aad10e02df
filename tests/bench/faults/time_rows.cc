// SPDX-License-Identifier: MIT
// F9 and F10: cycles that come late, clocks that are set.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tests/bench/faults/fault_rig.h"
#include "tests/bench/faults/rows.h"

namespace pipewright::bench {
namespace {

using std::chrono_literals::operator""ms;

constexpr Duration kPeriod = 10ms;

}  // namespace

/// The i-th overruns by 1 to 10 periods, that 1, 3 or more often in a row than is allowed.
Tally CyclesOverrun(std::uint64_t n, std::uint64_t seed) {
  const int most = EnvelopeConfig{}.overruns_max;
  Tally tally;
  FaultRig rig(seed);
  for (std::uint64_t i = 0; i < n; ++i) {
    if (!rig.Ready(tally)) {
      continue;
    }
    const int k = 1 + static_cast<int>(i % 10);
    const bool persists = i / 10 % 4 == 3;
    const int row = persists ? 1000 : 1 + rig.rng().Index(most - 1);
    int overruns = 0;
    int skipped = 0;
    const std::uint64_t before = rig.task().envelope_counters().overruns;
    rig.Begin();
    rig.runs = [&] {
      if (overruns >= row) {
        return true;
      }
      if (skipped < k) {
        ++skipped;
        return false;
      }
      skipped = 0;
      ++overruns;
      return true;
    };
    // Late for good: the count is reached, then the robot brakes for up to 0.5 s, seen as late as
    // a cycle is. What overruns by nine periods and more stops by the drives' own watchdogs, too.
    const Duration late = kPeriod * (k + 1);
    Requirement required{.window = 900ms};
    if (persists) {
      required = {.may_mask = false, .bound = late * most + 500ms + late + 60ms, .window = 2200ms};
    }
    rig.Judge(
        required,
        fmt::format("{} periods, {}", k, persists ? "for good" : fmt::format("{} in a row", row)),
        tally);
    rig.runs = nullptr;
    const std::uint64_t counted = rig.task().envelope_counters().overruns - before;
    if (counted != static_cast<std::uint64_t>(overruns)) {
      tally.Add(Outcome::kWrong);
      tally.Note(fmt::format("{} overruns, {} counted", overruns, counted));
    }
    rig.For(2 * kPeriod);  // on time again, before the next
  }
  tally.Note(fmt::format("stops at the {}th overrun in a row", most));
  return tally;
}

Tally ClocksStepped(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  FaultRig rig(seed);
  for (std::uint64_t i = 0; i < n; ++i) {
    if (!rig.Ready(tally)) {
      continue;
    }
    const int kind = static_cast<int>(i % 4);
    std::string what;
    Requirement required{};
    rig.Begin();
    hil::FaultyPort& port = rig.rng().Index(2) == 0 ? rig.base() : rig.arm();
    if (kind < 2) {
      // A stamp that hangs on the wall clock is an hour off; the program's own time is not.
      const Duration hour = std::chrono::hours(kind == 0 ? 1 : -1);
      what = kind == 0 ? "stamps an hour ahead" : "stamps an hour behind";
      const Duration clock = rig.clock() - rig.bench().now();
      port.SetStampOffset(clock + hour);
      rig.script().At(rig.bench().now() + 1ms * (20 + rig.rng().Index(300)),
                      [&port, clock] { port.SetStampOffset(clock); });
    } else {
      // The clock of program and stamps alike jumps ahead, as over a suspension, or is set back.
      const Duration step = 1ms * (10 + rig.rng().Index(2000)) * (kind == 2 ? 1 : -1);
      what = fmt::format("clock steps by {} ms", step / 1ms);
      rig.StepClock(step);
      // Within the age that a state may have it changes nothing.
      required.may_mask = step < 60ms && step > -60ms;
      required.may_mask = required.may_mask || kind == 2;  // new frames are fresh at once
    }
    required.window = 1100ms;
    rig.Judge(required, what, tally);
  }
  return tally;
}

}  // namespace pipewright::bench
