// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "ctrl/robot_program/robot_program.h"
#include "hil/plant/plant.h"
#include "hil/replay/depth_writer.h"
#include "hil/world/clearance.h"
#include "platform/can/frame.h"

namespace pipewright::hil {

/// The folder of evidence that a run leaves. Everything but run.json and report.html is written as
/// it happens, so that a run that breaks off leaves all that it saw.
///
///   run.json     every figure; "stop_reason": "running" until the end
///   trace.csv    one line a control cycle; nan: not known here
///   can.log      every frame of every bus, as candump -L writes it
///   depth.z16.zst    the depth frames, if that is asked for: see hil/replay/depth_recording.h
///   plan.jsonl   one object a planning step
///   map.bt, map.ot   the map, for OctoMap's tools
///   report.html  the page a person looks at
class RunFolder {
 public:
  /// Makes the folder. A folder that holds anything but an earlier run is left alone.
  /// @returns an error in words, or nothing
  std::string Open(const std::filesystem::path& folder, const nlohmann::ordered_json& head,
                   bool record_depth = false);

  /// @param plant, truth  null: not known here
  void Trace(const ControlReport& report, const Plant* plant, const Clearance* truth,
             const MapCounts& counts);
  void Can(const can::Frame& frame, std::string_view interface);
  /// A frame that the robot program gets at `given`; nothing if depth is not recorded.
  void Depth(const DepthFrame& frame, Time given);
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
  DepthWriter depth_;
  std::string failed_;
};

}  // namespace pipewright::hil
