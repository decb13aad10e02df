// SPDX-License-Identifier: MIT
#include "ctrl/daemon/config.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "ctrl/daemon/mode_codes.h"
#include "ctrl/robot_program/control_rate.h"
#include "ctrl/robot_program/site_config.h"
#include "perception/cloud/cloud.h"
#include "platform/robot/uf7.h"
#include "platform/toml/toml_source.h"
#include "platform/toml/toml_table.h"

namespace pipewright {
namespace {

constexpr std::size_t kInterfaceBytes = 15;  ///< the kernel's
constexpr std::size_t kSocketBytes = 107;    ///< likewise, of a socket's path
constexpr double kPixelsUsedAcross = 106;    ///< what the mapping task was tuned with

Duration Seconds(TomlTable& table, std::string_view key, double lo, double hi, Duration otherwise) {
  return FromSeconds(table.Number(key, lo, hi, ToSeconds(otherwise)));
}

/// Text of visible ASCII without quotes: it goes into messages and answers as it is.
std::string Plain(TomlTable& table, std::string_view key, std::size_t most,
                  const std::optional<std::string>& otherwise = {}) {
  std::string text = table.Text(key, otherwise);
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    return '!' <= c && c <= '~' && c != '"' && c != '\\';
  });
  if (table.Has(key) && (text.empty() || text.size() > most || !plain)) {
    table.Error(key, "must be 1 to " + std::to_string(most) +
                         " visible ASCII characters, none of them a quote or a backslash");
  }
  return text;
}

std::string Path(TomlTable& table, std::string_view key, std::size_t most,
                 const std::optional<std::string>& otherwise = {}) {
  std::string path = Plain(table, key, most, otherwise);
  if (!path.empty() && path.front() != '/') {
    table.Error(key, "must be an absolute path");
  }
  return path;
}

void ReadCan(TomlTable& table, DaemonConfig& c) {
  c.base_can = Plain(table, "base", kInterfaceBytes);
  c.arm_can = Plain(table, "arm", kInterfaceBytes, c.base_can);
  table.Finish();
}

void ReadBase(TomlTable& table, DaemonConfig& c) {
  c.base_modes = table.Text("mode_codes", c.base_modes);
  if (ModeCodesByName(c.base_modes) == nullptr) {
    table.Error("mode_codes", "must be one of " + ModeCodeNames());
  }
  table.Finish();
}

void ReadControl(TomlTable& table, DaemonConfig& c) {
  c.rate_hz = table.Number("rate_hz", 50, 1000, c.rate_hz);
  c.alpha = table.Number("alpha", 0.5, 0.999999, c.alpha);
  if (const std::string error = c.rate_hz > 0 ? ControlRateError(c.rate_hz, c.shared_bus()) : "";
      !error.empty()) {
    table.Error("rate_hz", error);
  }
  table.Finish();
}

void ReadRealtime(TomlTable& table, DaemonConfig& c) {
  c.ask_realtime = table.Bool("enabled", c.ask_realtime);
  c.require_realtime = table.Bool("required", c.ask_realtime);
  if (c.require_realtime && !c.ask_realtime) {
    table.Error("required", "cannot be had without realtime.enabled");
  }
  c.realtime.priority = table.Integer("priority", 1, 99, c.realtime.priority);
  c.realtime.cpu = table.Integer("cpu", -1, 1023, c.realtime.cpu);
  table.Finish();
}

void ReadIntrinsics(TomlTable& table, CameraIntrinsics& camera) {
  camera.width = table.Integer("width", 16, 848);
  camera.height = table.Integer("height", 16, 480);
  camera.fx = table.Number("fx", 1, 1e4);
  camera.fy = table.Number("fy", 1, 1e4);
  camera.cx = table.Number("cx", 0, std::max(1, camera.width));
  camera.cy = table.Number("cy", 0, std::max(1, camera.height));
  camera.z_min_m = table.Number("z_min_m", 0, 10);
  camera.z_max_m = table.Number("z_max_m", 0.1, 65);
  if (table.Has("z_min_m") && table.Has("z_max_m") && camera.z_max_m <= camera.z_min_m) {
    table.Error("z_max_m", "must be greater than z_min_m");
  }
}

int LeastStride(const CameraIntrinsics& camera) {
  int stride = 1;
  while ((camera.width + stride - 1) / stride * ((camera.height + stride - 1) / stride) >
         Cloud::kMaxPoints) {
    ++stride;
  }
  return stride;
}

void ReadCamera(TomlTable& table, DaemonConfig& c) {
  CameraChoice& camera = c.camera;
  const std::string source = table.Text("source");
  if (source == "v4l2") {
    camera.source = CameraSource::kV4l2;
    camera.path = Path(table, "device", kSocketBytes);
    ReadIntrinsics(table, camera.intrinsics);
    camera.stamp_offset = FromSeconds(1e-3 * table.Number("stamp_offset_ms", -100, 100, 0.0));
    camera.stride =
        std::max(1, static_cast<int>(std::lround(camera.intrinsics.width / kPixelsUsedAcross)));
  } else if (source == "stream") {
    camera.source = CameraSource::kStream;
    camera.path = Path(table, "socket", kSocketBytes);
  } else if (table.Has("source")) {
    table.Error("source", "must be v4l2 or stream");
  }
  camera.stride = table.Integer("stride", 1, 16, camera.stride);
  if (camera.stride > 0 && camera.stride < LeastStride(camera.intrinsics)) {
    table.Error("stride", "leaves more pixels than can be used: must be at least " +
                              std::to_string(LeastStride(camera.intrinsics)));
  }
  c.camera_timeout = Seconds(table, "timeout_s", 0.1, 10, c.camera_timeout);
  table.Finish();
}

void ReadMission(TomlTable& table, DaemonConfig& c) {
  const std::string planner = table.Text("planner", "cfnbv");
  if (planner != "cfnbv" && planner != "cfnbv_paper") {
    table.Error("planner", "must be cfnbv or cfnbv_paper");
  }
  c.planner = planner == "cfnbv_paper" ? PlannerKind::kCfnbvPaper : PlannerKind::kCfnbv;
  c.seed = table.Integer("seed", 0, 1'000'000'000, c.seed);
  c.time_limit_s = table.Number("time_limit_s", 1, 1e5, c.time_limit_s);
  c.autostart = table.Bool("autostart", c.autostart);
  table.Finish();
}

void ReadWatchdog(TomlTable& table, DaemonConfig& c) {
  c.task_bound = Seconds(table, "tasks_s", 0.1, 10, c.task_bound);
  c.planning_bound = Seconds(table, "planning_s", 0.1, 300, c.planning_bound);
  table.Finish();
}

void ReadService(TomlTable& table, DaemonConfig& c) {
  c.socket = Path(table, "socket", kSocketBytes, c.socket);
  table.Finish();
}

void ReadConfig(TomlTable& root, DaemonConfig& c) {
  const auto read = [&](std::string_view key, bool required, auto read_one) {
    if (auto table = root.Table(key, required)) {
      read_one(*table, c);
    }
  };
  read("can", true, ReadCan);  // before control: it says how many buses there are
  read("base", false, ReadBase);
  read("control", false, ReadControl);
  read("realtime", false, ReadRealtime);
  read("camera", true, ReadCamera);
  ReadSite(root, c.site);
  read("mission", false, ReadMission);
  read("watchdog", false, ReadWatchdog);
  read("service", false, ReadService);
  root.Finish();
}

/// Joints named as where the arm starts can be there.
void CheckStart(const StartPose& start, std::vector<std::string>& errors) {
  const auto& joints = TracerUf7().arm.joints;
  for (std::size_t i = 0; i < std::min(start.joints_rad.size(), joints.size()); ++i) {
    const double q_rad = start.joints_rad[i];
    if (!(joints[i].q_min_rad <= q_rad && q_rad <= joints[i].q_max_rad)) {
      errors.push_back(start.where + ".joints_rad: joint " + std::to_string(i + 1) + " at " +
                       std::to_string(q_rad) + " is beyond its limits, [" +
                       std::to_string(joints[i].q_min_rad) + ", " +
                       std::to_string(joints[i].q_max_rad) + "]");
    }
  }
}

}  // namespace

DaemonConfigResult ParseDaemonConfig(std::string_view toml, const std::string& origin) {
  DaemonConfigResult result;
  ReadToml(toml, origin, result.errors, [&](TomlTable& root) {
    DaemonConfig config;
    ReadConfig(root, config);
    CheckStart(config.site.start, result.errors);
    if (result.errors.empty()) {
      result.config = std::move(config);
    }
  });
  return result;
}

DaemonConfigResult LoadDaemonConfig(const std::string& file) {
  std::vector<std::string> errors;
  const auto source = ReadTomlFile(file, "cannot be read", errors);
  return source ? ParseDaemonConfig(source->text, file) : DaemonConfigResult{{}, errors};
}

RobotProgramConfig ProgramConfigOf(const DaemonConfig& config) {
  RobotProgramConfig program;
  SetSite(config.site, TracerUf7(), &program);
  program.camera_timeout = config.camera_timeout;

  ControlTaskConfig& control = program.control;
  control.law.constraints.period_s = 1 / config.rate_hz;
  control.law.constraints.alpha = config.alpha;
  control.arm.cycle_ms = ArmCycle_ms(config.rate_hz, config.shared_bus());
  control.base.mode_codes = *ModeCodesByName(config.base_modes);
  control.scans_correct = true;

  program.mapping.seed = static_cast<std::uint64_t>(config.seed);
  program.mapping.localize = true;
  program.mapping.cloud.stride = config.camera.stride;

  program.mission = DefaultMission();
  program.mission.planner = config.planner;
  program.mission.seed = static_cast<std::uint64_t>(config.seed);
  program.mission.mission_timeout = FromSeconds(config.time_limit_s);
  if (config.planner == PlannerKind::kCfnbv) {
    control.law.reached = 0.02;  // a view's worth does not hang on the last centimetre
  }
  return program;
}

}  // namespace pipewright
