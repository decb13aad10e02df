// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "ctrl/daemon/service_machine.h"
#include "ctrl/robot_program/threads.h"
#include "perception/map/voxel_grid.h"
#include "plan/mission/mission.h"

namespace pipewright {

/// What `pipewright status` shows: one moment of the service. Texts are plain ASCII without quotes
/// and backslashes, so that they go into JSON as they are.
struct ServiceReport {
  ServiceState state = ServiceState::kNoBus;
  std::string_view reason;
  bool latched = false;
  double uptime_s = 0;
  std::string_view base_can;
  std::string_view arm_can;
  std::string_view bus_error;
  bool base_heard = false;  ///< within the last second
  bool arm_heard = false;
  double battery_V = 0;  ///< 0: not known
  bool base_emergency_stop = false;
  std::string_view camera_error;
  std::uint64_t camera_frames = 0;
  bool fifo = false;  ///< granted
  bool memory_locked = false;
  // of the run, or of the last one
  std::uint64_t runs = 0;
  double run_s = 0;
  ControlPhase phase = ControlPhase::kStarting;
  MissionState mission = MissionState::kStart;
  StopReason stop = StopReason::kNone;
  MapCounts counts;
  int plan_steps = 0;
  int goals_reached = 0;
  Vector3d pose = Vector3d::Zero();  ///< x, y [m], phi [rad]
  CycleStats cycles;
  Duration worst_cycle{};
};

const char* Name(ControlPhase phase);

/// One JSON object, without a line's end. @returns its bytes, at most out.size()
std::size_t ReportJson(const ServiceReport& report, std::span<char> out);

/// {"ok":true} or {"ok":false,"error":...}; `error` as the texts above.
std::size_t AnswerJson(std::string_view error, std::span<char> out);

}  // namespace pipewright
