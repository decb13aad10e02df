// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ctrl/robot_program/robot_program.h"
#include "platform/core/depth_frame.h"
#include "platform/linux/realtime.h"
#include "platform/toml/site.h"

namespace pipewright {

enum class CameraSource : std::uint8_t {
  kV4l2,    ///< a device of the kernel that gives Z16
  kStream,  ///< a Unix socket at which frames come, see platform/core/depth_wire.h
};

struct CameraChoice {
  CameraSource source = CameraSource::kV4l2;
  std::string path;             ///< of the device, or of the socket
  CameraIntrinsics intrinsics;  ///< of a V4L2 device; frames of a stream bring their own
  Duration stamp_offset{};      ///< from a V4L2 stamp to the middle of the exposure
  int stride = 2;               ///< every stride-th pixel of every stride-th row is used
};

/// What pipewrightd is told. The format is documented in ctrl/daemon/pipewrightd.toml.
struct DaemonConfig {
  std::string base_can;
  std::string arm_can;  ///< base_can: one bus for both
  std::string base_modes = "sdk";
  double rate_hz = 100;
  double alpha = 0.7;
  bool ask_realtime = true;
  bool require_realtime = true;
  RealtimeRequest realtime;
  CameraChoice camera;
  Duration camera_timeout = std::chrono::seconds(1);
  Site site;
  PlannerKind planner = PlannerKind::kCfnbv;
  int seed = 1;
  double time_limit_s = 3600;
  bool autostart = false;
  Duration task_bound = std::chrono::seconds(1);       ///< control and mapping answer within this
  Duration planning_bound = std::chrono::seconds(30);  ///< planning does
  std::string socket = "/run/pipewright/status.sock";

  bool shared_bus() const { return base_can == arm_can; }
};

/// A configuration, or everything that is wrong with it, one line each: "file:line:column: key:
/// what".
struct DaemonConfigResult {
  std::optional<DaemonConfig> config;
  std::vector<std::string> errors;
};

/// @param origin  the name in error messages
DaemonConfigResult ParseDaemonConfig(std::string_view toml, const std::string& origin);
DaemonConfigResult LoadDaemonConfig(const std::string& file);

/// The same configuration as TOML, every default written out: ParseDaemonConfig() gives it back.
std::string DaemonConfigText(const DaemonConfig& config);

/// @param config  as ParseDaemonConfig() gives it
RobotProgramConfig ProgramConfigOf(const DaemonConfig& config);

}  // namespace pipewright
