// SPDX-License-Identifier: MIT
#include "hil/cli/emulate_run.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <thread>
#include <vector>

#include "hil/cli/bus_load.h"
#include "hil/cli/camera_thread.h"
#include "hil/emulator/emulator.h"
#include "platform/core/latest.h"
#include "platform/linux/clock.h"
#include "platform/linux/realtime.h"
#include "platform/robot/uf7.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;
using Json = nlohmann::ordered_json;

constexpr int kPriority = 70;       ///< below a robot program's control thread
constexpr Duration kStall = 100ms;  ///< of lateness that is not made up for
constexpr Duration kTruthPeriod = 20ms;
constexpr Duration kTellPeriod = 100ms;
constexpr Time kBooted{200ms};  ///< every device is, by then
constexpr Duration kWaitPeriod = 50ms;

class Emulation {
 public:
  Emulation(const Scenario& scenario, const EmulationOptions& options, std::deque<WirePort>& wires,
            DepthSender& camera, const EmulationHooks& hooks)
      : scenario_(scenario),
        options_(options),
        wires_(wires),
        hooks_(hooks),
        emulator_(scenario, HomeJoints(TracerUf7()), options.seed, PortsOf(wires), options.tracer),
        camera_(
            emulator_, [&camera] { return camera.HasReaders(); },
            [&camera](const DepthFrame& frame) { camera.Send(frame); }),
        sender_(camera) {}

  Json Run();

 private:
  static std::vector<Port*> PortsOf(std::deque<WirePort>& wires) {
    std::vector<Port*> ports;
    ports.reserve(wires.size());
    for (WirePort& wire : wires) {
      ports.push_back(&wire);
    }
    return ports;
  }

  // the devices' thread
  void DeviceLoop();
  void Tick();
  void Tell();
  // this one's
  std::string Wait();
  Json Figures(const std::string& stop_reason);
  Json Wires() const;
  Json Base() const;
  Json Arm() const;

  const Scenario& scenario_;
  const EmulationOptions& options_;
  std::deque<WirePort>& wires_;
  const EmulationHooks& hooks_;
  Emulator emulator_;
  CameraThread camera_;
  const DepthSender& sender_;  ///< the camera thread's, until that has ended
  std::atomic<bool> quit_ = false;
  std::atomic<bool> started_ = false;
  std::atomic<bool> gone_ = false;
  Latest<EmulationProgress> progress_;  // devices -> this thread
  RealtimeGrant grant_;
  Time epoch_{};
  Time now_{};
  Time next_truth_{};
  Time next_told_ = kBooted;
  Duration late_max_{};
  int stalls_ = 0;
};

void Emulation::DeviceLoop() {
  if (options_.ask_fifo) {
    grant_ = MakeRealtime({.priority = kPriority});
  }
  for (WirePort& wire : wires_) {
    wire.Discard();  // said before there was a device to hear it
  }
  epoch_ = Now();
  while (!quit_) {
    const Duration late = Time{Now() - epoch_} - now_;
    if (late > kStall) {
      ++stalls_;
      epoch_ += late - Emulator::kTick;
      continue;
    }
    late_max_ = std::max(late_max_, late);
    for (Duration left = late; left >= Emulator::kTick; left -= Emulator::kTick) {
      now_ += Emulator::kTick;
      Tick();
    }
    SleepUntil(epoch_ + (now_ + Emulator::kTick).time_since_epoch());
  }
}

void Emulation::Tick() {
  emulator_.Step(now_);
  camera_.Look(now_, Now());
  if (now_ >= next_truth_) {
    next_truth_ += kTruthPeriod;
    emulator_.Measure(now_);
  }
  if (now_ >= next_told_) {
    next_told_ += kTellPeriod;
    Tell();
  }
}

void Emulation::Tell() {
  const DeviceSet& devices = emulator_.devices();
  const BasePose& pose = emulator_.plant().base();
  EmulationProgress told{.now = now_,
                         .base_in_can_mode = devices.tracer().can_mode(),
                         .x_m = pose.x_m,
                         .y_m = pose.y_m,
                         .yaw_rad = pose.yaw_rad,
                         .contacts = emulator_.truth().contacts()};
  for (int i = 0; i < kArmNodes; ++i) {
    told.joints_enabled += devices.joint(i).drive_state() == DriveState::kOperationEnabled ? 1 : 0;
  }
  progress_.Write(told);
  started_ = true;
  gone_ = std::any_of(wires_.begin(), wires_.end(), [](const WirePort& w) { return w.gone(); });
}

std::string Emulation::Wait() {
  Time next_progress{};
  while (!gone_) {
    const EmulationProgress& now = progress_.Read();
    if (hooks_.interrupted && hooks_.interrupted()) {
      return "interrupted";
    }
    if (options_.time_limit_s && now.now >= Time{FromSeconds(*options_.time_limit_s)}) {
      return "time_limit";
    }
    if (now.now >= next_progress && hooks_.progress) {
      next_progress = now.now + 1s;
      hooks_.progress(now);
    }
    SleepUntil(Now() + kWaitPeriod);
  }
  return "bus_gone";
}

Json Emulation::Run() {
  std::thread devices([this] { DeviceLoop(); });
  if (!options_.camera.empty()) {
    camera_.Start();
  }
  while (!started_) {
    SleepUntil(Now() + kWaitPeriod);
  }
  if (hooks_.started) {
    hooks_.started();
  }
  const std::string stop_reason = Wait();
  quit_ = true;
  devices.join();
  camera_.Stop();
  return Figures(stop_reason);
}

Json Emulation::Wires() const {
  Json wires = Json::array();
  const bool shared = wires_.size() == 1;
  for (const WirePort& wire : wires_) {
    const bool arm_alone = wires.size() == 1;
    const double base = arm_alone ? 0 : BaseLoad(wire.bitrate());
    const double arm = shared || arm_alone ? ArmLoad(options_.rate_hz, wire.bitrate()) : 0;
    wires.push_back({{"interface", wire.interface()},
                     {"carries", shared      ? "base and arm"
                                 : arm_alone ? "arm"
                                             : "base"},
                     {"bitrate", wire.bitrate()},
                     {"tx", wire.socket().tx()},
                     {"tx_dropped", wire.socket().tx_dropped()},
                     {"rx", wire.socket().rx()},
                     {"rx_dropped", wire.socket().rx_dropped()},
                     {"error_frames", wire.error_frames()},
                     {"bus_off", wire.bus_offs()},
                     {"emergencies", wire.emergencies()},
                     {"link_losses", wire.link_losses()},
                     {"load_expected", base + arm},
                     {"load_peak", wire.load_peak()}});
  }
  return wires;
}

Json Emulation::Base() const {
  const TracerDevice& tracer = emulator_.devices().tracer();
  const BasePose& pose = emulator_.plant().base();
  return {{"modes", std::string(options_.tracer.modes.source)},
          {"can_mode", tracer.can_mode()},
          {"exception", tracer.exception()},
          {"watchdog_trips", tracer.watchdog_trips()},
          {"rejected", tracer.rejected()},
          {"travel_m", emulator_.base_travel_m()},
          {"pose", {pose.x_m, pose.y_m, pose.yaw_rad}}};
}

Json Emulation::Arm() const {
  Json joints = Json::array();
  for (int i = 0; i < kArmNodes; ++i) {
    const Cia402Node& joint = emulator_.devices().joint(i);
    joints.push_back({{"state", can::Name(joint.drive_state())},
                      {"position_rad", emulator_.plant().joints_rad()(i)},
                      {"rejected", joint.rejected()}});
  }
  return {{"travel_rad", emulator_.joint_travel_rad()},
          {"hard_stops", emulator_.plant().hard_stops()},
          {"joints", joints}};
}

Json Emulation::Figures(const std::string& stop_reason) {
  const auto granted = [this](int error) {
    return std::string(!options_.ask_fifo ? "not asked for"
                       : error == 0       ? "granted"
                                          : std::strerror(error));
  };
  const Truth& truth = emulator_.truth();
  const Truth::Coverage coverage = truth.coverage();
  Json run;
  run["scenario"] = scenario_.name;
  run["seed"] = options_.seed;
  run["stop_reason"] = stop_reason;
  run["time_s"] = ToSeconds(now_);
  run["bus"] = Wires();
  run["base"] = Base();
  run["arm"] = Arm();
  run["camera"] = {{"socket", options_.camera},
                   {"frames", camera_.frames()},
                   {"skipped", camera_.skipped()},
                   {"readers", sender_.readers_seen()},
                   {"readers_lost", sender_.readers_lost()}};
  run["truth"] = {{"contacts", truth.contacts()},
                  {"touched", truth.touched()},
                  {"covered", coverage.covered},
                  {"coverable", coverage.coverable},
                  {"coverage", coverage.ratio}};
  run["realtime"] = {{"fifo", granted(grant_.scheduler_error)},
                     {"memory_lock", granted(grant_.memory_error)},
                     {"late_max_ms", 1e3 * ToSeconds(late_max_)},
                     {"stalls", stalls_}};
  return run;
}

}  // namespace

Json RunEmulation(const Scenario& scenario, const EmulationOptions& options,
                  std::deque<WirePort>& wires, DepthSender& camera, const EmulationHooks& hooks) {
  return std::make_unique<Emulation>(scenario, options, wires, camera, hooks)->Run();
}

}  // namespace pipewright::hil
