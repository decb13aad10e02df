// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "hil/replay/depth_reader.h"
#include "hil/replay/recorded_bus.h"

namespace pipewright::hil {

/// Of what a replay was made.
struct ReplayFiles {
  std::string log;
  std::string run;
  std::string depth;  ///< empty: none
};

/// The object of `pipewright replay --json`: "files", "program" as RunReplay() returns it, and
/// "compare", which is null unless asked for.
/// @param depth  null: none
nlohmann::ordered_json ReplayJson(const ReplayFiles& files, const RecordedBus& bus,
                                  const DepthReader* depth, nlohmann::ordered_json program,
                                  bool compare);

/// The same as a short table for people.
std::string ReplayTable(const nlohmann::ordered_json& replay);

}  // namespace pipewright::hil
