// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "tests/bench/faults/outcome.h"

namespace pipewright::bench {

/// A kind of fault.
struct Row {
  const char* id;    ///< "F3"
  const char* what;  ///< in a few words
  const char* rule;  ///< what is injected, and how it is judged
  std::uint64_t n;   ///< cases unless asked otherwise
  Tally (*run)(std::uint64_t n, std::uint64_t seed);
};

/// In the order of their ids.
std::span<const Row> Rows();

// Faults of the devices and of the program as a whole.
Tally ProgramDies(std::uint64_t n, std::uint64_t seed);
Tally EmergencyStops(std::uint64_t n, std::uint64_t seed);
// Of the wire.
Tally FramesLost(std::uint64_t n, std::uint64_t seed);
Tally FramesOutOfOrder(std::uint64_t n, std::uint64_t seed);
Tally FramesDamaged(std::uint64_t n, std::uint64_t seed);
Tally ErrorFrames(std::uint64_t n, std::uint64_t seed);
Tally BusOverloaded(std::uint64_t n, std::uint64_t seed);
// Of time.
Tally CyclesOverrun(std::uint64_t n, std::uint64_t seed);
Tally ClocksStepped(std::uint64_t n, std::uint64_t seed);
// Of numbers.
Tally OddNumbers(std::uint64_t n, std::uint64_t seed);
Tally HardQps(std::uint64_t n, std::uint64_t seed);
Tally WrongCovariances(std::uint64_t n, std::uint64_t seed);
// Of memory, files and configurations.
Tally StoresFull(std::uint64_t n, std::uint64_t seed);
Tally LogsDamaged(std::uint64_t n, std::uint64_t seed);
Tally BadConfigurations(std::uint64_t n, std::uint64_t seed);
Tally CyclesThatAllocate(std::uint64_t n, std::uint64_t seed);
// Of what is sensed: whole missions.
Tally MissionsUnderFaults(std::uint64_t n, std::uint64_t seed);

}  // namespace pipewright::bench
