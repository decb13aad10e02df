// SPDX-License-Identifier: MIT
// pipewrightd: the robot program on the robot's computer. `pipewrightd --help` tells the rest.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <memory>

#include "ctrl/daemon/can_wires.h"
#include "ctrl/daemon/config.h"
#include "ctrl/daemon/realtime_check.h"
#include "ctrl/daemon/service.h"
#include "platform/linux/clock.h"
#include "platform/linux/depth_socket.h"
#include "platform/linux/journal.h"
#include "platform/linux/stop_signals.h"
#include "platform/linux/v4l2_depth.h"

namespace pipewright {
namespace {

constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;

struct Options {
  std::string config = "/etc/pipewright/pipewrightd.toml";
  bool check = false;
  bool print = false;
};

/// A service keeps what outlives it where systemd says (StateDirectory=).
LatchFile LatchOfEnvironment() {
  const char* folder = std::getenv("STATE_DIRECTORY");
  return LatchFile(folder == nullptr ? "" : std::string(folder) + "/latch");
}

/// @returns whether the robot may be started with what was granted
bool CheckRealtime(const DaemonConfig& config, const RealtimeGrant& grant) {
  const std::vector<std::string> refusals = RefusalWords(grant, config.realtime);
  for (const std::string& refusal : refusals) {
    Say(config.require_realtime ? Severity::kError : Severity::kWarning, refusal);
  }
  if (!refusals.empty() && config.require_realtime) {
    Say(Severity::kError, "the robot is not run without; realtime.required = false would do so");
    return false;
  }
  return true;
}

/// The camera that the configuration names. On the heap: the stream's holds a whole frame.
class Camera {
 public:
  explicit Camera(const CameraChoice& choice)
      : device_(choice.path, choice.intrinsics, choice.stamp_offset),
        stream_(choice.path),
        source_(choice.source == CameraSource::kV4l2 ? static_cast<FrameSource&>(device_source_)
                                                     : stream_source_) {}

  FrameSource& source() { return source_; }

 private:
  V4l2Depth device_;
  DepthSocket stream_;
  FrameSourceOf<V4l2Depth> device_source_{device_};
  FrameSourceOf<DepthSocket> stream_source_{stream_};
  FrameSource& source_;
};

int Serve(const DaemonConfig& config) {
  StopSignals::Block();
  const RealtimeGrant grant =
      config.ask_realtime ? TryRealtime(config.realtime) : RealtimeGrant{EPERM, EPERM, 0};
  if (config.ask_realtime && !CheckRealtime(config, grant)) {
    return kFailed;
  }
  LineServer server;
  if (server.Open(config.socket) != Status::kOk) {
    Say(Severity::kError, server.error_text());
    return kFailed;
  }
  const LatchFile latch = LatchOfEnvironment();
  if (!latch.kept()) {
    Say(Severity::kWarning, "STATE_DIRECTORY is not set: an emergency stop ends with the service");
  }
  const ServiceNotify notify = ServiceNotify::OfEnvironment();
  CanWires wires(config.base_can, config.arm_can);
  const auto camera = std::make_unique<Camera>(config.camera);
  const auto service =
      std::make_unique<RobotService>(config, wires, camera->source(), notify, server, latch, grant);
  service->Begin(Now());
  while (service->Step(Now(), StopSignals::Pending())) {
    if (service->stuck(Now())) {
      Say(Severity::kError, "a task does not return; the devices' own watchdogs stop them");
      std::_Exit(kFailed);
    }
    SleepUntil(Now() + RobotService::kPeriod);
  }
  return kOk;
}

int Main(const Options& options) {
  const DaemonConfigResult loaded = LoadDaemonConfig(options.config);
  for (const std::string& error : loaded.errors) {
    Say(Severity::kError, error);
  }
  if (!loaded.config) {
    return kBadInput;
  }
  if (options.print) {
    fmt::print("{}", DaemonConfigText(*loaded.config));
  }
  return options.print || options.check ? kOk : Serve(*loaded.config);
}

}  // namespace
}  // namespace pipewright

int main(int argc, char** argv) {
  CLI::App app{"pipewrightd: the robot program on the robot's computer, as a service."};
  app.set_version_flag("--version", PIPEWRIGHT_VERSION);
  pipewright::Options options;
  app.add_option("--config", options.config, "what the robot is and where it works, TOML")
      ->capture_default_str();
  app.add_flag("--check", options.check, "only say what is wrong with the configuration");
  app.add_flag("--print-config", options.print,
               "only print the configuration, every default written out");
  app.footer(
      "Talk to it with `pipewright status`, start, stop, estop and rearm.\n"
      "Exit code: 0 it was asked to end (SIGTERM, SIGINT), and the robot is at rest; 1 it could "
      "not\n"
      "run; 2 bad usage or configuration, every error as FILE:LINE:COLUMN: KEY: WHAT.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return pipewright::Main(options);
}
