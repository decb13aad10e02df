// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "ctrl/robot_program/robot_program.h"
#include "hil/plant/plant.h"
#include "hil/world/clearance.h"
#include "platform/can/frame.h"

namespace pipewright::hil {

/// The folder of evidence that a run leaves. Everything but run.json and report.html is written as
/// it happens, so that a run that breaks off leaves all that it saw.
///
///   run.json     every figure; "stop_reason": "running" until the end
///   trace.csv    one line a control cycle
///   can.log      every frame of every bus, as candump -L writes it
///   plan.jsonl   one object a planning step
///   map.bt, map.ot   the map, for OctoMap's tools
///   report.html  the page a person looks at
class RunFolder {
 public:
  /// Makes the folder. A folder that holds anything but an earlier run is left alone.
  /// @returns an error in words, or nothing
  std::string Open(const std::filesystem::path& folder, const nlohmann::ordered_json& head);

  void Trace(const ControlReport& report, const Plant& plant, const Clearance& truth,
             const MapCounts& counts);
  void Can(const can::Frame& frame, std::string_view interface);
  void Plan(const nlohmann::ordered_json& step);
  void Text(const char* name, const std::string& text);
  void Map(const VoxelGrid& map);

  /// Flushes everything. @returns an error in words if anything could not be written, or nothing
  std::string Close();

  const std::filesystem::path& path() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::ofstream trace_;
  std::ofstream can_;
  std::ofstream plan_;
  std::string failed_;
};

}  // namespace pipewright::hil
