// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>

#include "hil/cli/run_figures.h"
#include "hil/cli/run_folder.h"

namespace pipewright::hil {

/// What only the emulator knows.
struct TruthNow {
  double coverage_ratio = 0;
  int contacts = 0;
};

/// How a run is going, for a person who waits.
struct RunProgress {
  Time now{};
  MissionState state = MissionState::kStart;
  MapCounts counts;
  std::optional<TruthNow> truth;  ///< none: the devices are elsewhere
};

struct RunHooks {
  std::function<void(const RunProgress&)> progress;  ///< once a simulated second
  std::function<bool()> interrupted;                 ///< asked every cycle
};

/// One thread on a virtual clock: the robot program and the emulated devices on a LoopbackBus, in
/// steps of 1 ms. A run is a function of scenario, options and seed; only wall-clock figures differ
/// between two. With options.realtime it waits for the wall clock at each cycle.
/// @returns run.json's object; the folder holds everything else
nlohmann::ordered_json RunVirtual(const Scenario& scenario, const InspectionOptions& options,
                                  RunFolder& folder, const RunHooks& hooks);

}  // namespace pipewright::hil
