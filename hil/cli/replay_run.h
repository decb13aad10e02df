// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "hil/cli/program_record.h"
#include "hil/replay/depth_reader.h"
#include "hil/replay/recorded_bus.h"
#include "plan/mission/mission.h"

namespace pipewright::hil {

/// How a replay is going, for a person who waits.
struct ReplayProgress {
  Time now{};
  MissionState state = MissionState::kStart;
  MapCounts counts;
  std::uint64_t differences = 0;
};

struct ReplayInput {
  RecordedProgram program;
  RecordedBus& bus;              ///< open
  DepthReader* depth = nullptr;  ///< open; null: the program gets no frame
  double speed = 0;              ///< times the wall clock's; 0: as fast as it goes
  std::function<void(const ReplayProgress&)> progress = {};  ///< once a simulated second
};

/// The robot program in virtual time, on the schedule of the run that was recorded: CAN and depth
/// frames reach it when they did then. It ends with the log, or with the last whole depth frame of
/// a recording that breaks off, since from the next one on the program would have known less than
/// it did.
/// @returns what the program did, as an object: its ends, its plans, its map; the commands are in
///          input.bus.comparison()
nlohmann::ordered_json RunReplay(const ReplayInput& input);

}  // namespace pipewright::hil
