// SPDX-License-Identifier: MIT
#include "hil/cli/gateway_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <thread>

#include "hil/cli/table_rows.h"
#include "platform/core/latest.h"
#include "platform/linux/clock.h"
#include "platform/linux/realtime.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;
using Json = nlohmann::ordered_json;

constexpr Duration kTick = 1ms;
constexpr Duration kTellPeriod = 50ms;
constexpr Duration kWaitPeriod = 50ms;
constexpr Duration kFarewell = 50ms;  ///< for the last words to both sides

class GatewayRun {
 public:
  GatewayRun(const GatewayOptions& options, WirePort& wire, const GatewayHooks& hooks)
      : options_(options), wire_(wire), hooks_(hooks), gateway_(options.config, wire) {}

  Json Run() {
    std::thread steps([this] { Loop(); });
    const std::string stop_reason = Wait();
    quit_ = true;
    steps.join();
    return Figures(stop_reason);
  }

 private:
  // the gateway's thread
  void Loop();
  void Tell(Time now);
  // this one's
  std::string Wait();
  Json Figures(const std::string& stop_reason) const;
  Json Controller() const;

  const GatewayOptions& options_;
  WirePort& wire_;
  const GatewayHooks& hooks_;
  XarmGateway gateway_;
  std::atomic<bool> quit_ = false;
  Latest<GatewayProgress> progress_;  // gateway -> this thread
  RealtimeGrant grant_;
  Duration time_{};
  Duration late_max_{};
  std::uint64_t missed_ = 0;
};

void GatewayRun::Loop() {
  if (options_.ask_fifo) {
    grant_ = MakeRealtime({.priority = options_.priority});
  }
  wire_.Discard();  // said before there was a node to hear it
  const Time start = Now();
  Time next_told{};
  PeriodicTimer tick(kTick, start);
  while (!quit_) {
    const Time now = tick.Wait();
    gateway_.Step(now);
    if (now >= next_told) {
      next_told = now + kTellPeriod;
      Tell(now);
    }
  }
  gateway_.Stop(Now());
  for (const Time end = Now() + kFarewell; Now() < end;) {
    gateway_.Step(tick.Wait());
  }
  time_ = Now() - start;
  late_max_ = tick.worst_latency();
  missed_ = tick.missed();
}

void GatewayRun::Tell(Time now) {
  GatewayProgress told{.now = now,
                       .phase = gateway_.phase(),
                       .trouble = gateway_.trouble(),
                       .velocities = gateway_.counters().velocities,
                       .measured = gateway_.report().has_value(),
                       .bus_gone = wire_.gone()};
  if (told.measured) {
    told.position_rad = gateway_.report()->position_rad;
  }
  for (int i = 0; i < kXarmJoints; ++i) {
    told.joints_enabled += gateway_.node(i).drive_state() == DriveState::kOperationEnabled ? 1 : 0;
  }
  progress_.Write(told);
}

std::string GatewayRun::Wait() {
  const Time start = Now();
  Time next_progress = start;
  XarmPhase phase = XarmPhase::kConnecting;
  while (true) {
    SleepUntil(Now() + kWaitPeriod);
    const GatewayProgress& told = progress_.Read();
    const Time now = Now();
    if (hooks_.progress && (now >= next_progress || told.phase != phase)) {
      next_progress = now + 1s;
      phase = told.phase;
      hooks_.progress(told);
    }
    if (hooks_.interrupted && hooks_.interrupted()) {
      return "interrupted";
    }
    if (told.phase == XarmPhase::kRefused) {
      return "refused";
    }
    if (told.bus_gone) {
      return "bus_gone";
    }
    if (options_.time_limit_s && now - start >= FromSeconds(*options_.time_limit_s)) {
      return "time_limit";
    }
  }
}

Json GatewayRun::Controller() const {
  const XarmClientConfig& config = options_.config.controller;
  const XarmGateway::Counters& counters = gateway_.counters();
  Json controller = {{"host", options_.controller},
                     {"address", config.address},
                     {"report_port", config.report_port},
                     {"phase", Name(gateway_.phase())},
                     {"trouble", gateway_.trouble()}};
  controller["firmware"] = nullptr;
  if (const auto& version = gateway_.version()) {
    controller["firmware"] =
        fmt::format("{}.{}.{}", version->major, version->minor, version->revision);
  }
  controller["connections"] = counters.connections;
  controller["requests"] = gateway_.client().asked();
  controller["velocities"] = counters.velocities;
  controller["strays"] = gateway_.client().strays();
  controller["reports"] = counters.reports;
  controller["bad_reports"] = gateway_.client().bad_reports();
  controller["silence_max_ms"] = 1e3 * ToSeconds(counters.silence_max);
  controller["faults"] = counters.faults;
  return controller;
}

Json GatewayRun::Figures(const std::string& stop_reason) const {
  const auto granted = [this](int error) {
    return std::string(!options_.ask_fifo ? "not asked for"
                       : error == 0       ? "granted"
                                          : std::strerror(error));
  };
  Json joints = Json::array();
  for (int i = 0; i < kXarmJoints; ++i) {
    const Cia402Node& node = gateway_.node(i);
    Json position = nullptr;
    if (gateway_.report()) {
      position = gateway_.report()->position_rad(i);
    }
    joints.push_back({{"state", can::Name(node.drive_state())},
                      {"position_rad", position},
                      {"rejected", node.rejected()}});
  }
  Json run;
  run["stop_reason"] = stop_reason;
  run["time_s"] = ToSeconds(time_);
  run["controller"] = Controller();
  run["bus"] = {{"interface", wire_.interface()},
                {"tx", wire_.socket().tx()},
                {"tx_dropped", wire_.socket().tx_dropped()},
                {"rx", wire_.socket().rx()},
                {"rx_dropped", wire_.socket().rx_dropped()},
                {"error_frames", wire_.error_frames()},
                {"bus_off", wire_.bus_offs()},
                {"emergencies", wire_.emergencies()},
                {"link_losses", wire_.link_losses()},
                {"load_peak", wire_.load_peak()}};
  run["joints"] = joints;
  run["realtime"] = {{"fifo", granted(grant_.scheduler_error)},
                     {"memory_lock", granted(grant_.memory_error)},
                     {"late_max_ms", 1e3 * ToSeconds(late_max_)},
                     {"missed", missed_}};
  return run;
}

}  // namespace

Json RunGateway(const GatewayOptions& options, WirePort& wire, const GatewayHooks& hooks) {
  return std::make_unique<GatewayRun>(options, wire, hooks)->Run();
}

std::string GatewayTable(const Json& run) {
  const Json& controller = run["controller"];
  const Json& bus = run["bus"];
  const Json& realtime = run["realtime"];
  TableRows row;
  row("ended", fmt::format("{} after {:.1f} s", run["stop_reason"].get<std::string>(),
                           run["time_s"].get<double>()));
  const Json& firmware = controller["firmware"];
  row("controller", fmt::format("{}, {}: {}", controller["host"].get<std::string>(),
                                firmware.is_null() ? "never spoken with"
                                                   : "firmware " + firmware.get<std::string>(),
                                controller["phase"].get<std::string>()));
  if (const auto trouble = controller["trouble"].get<std::string>(); !trouble.empty()) {
    row("trouble", trouble);
  }
  row("requests", fmt::format("{}, of them {} velocities; {} answers that nobody waited for",
                              controller["requests"].get<std::uint64_t>(),
                              controller["velocities"].get<std::uint64_t>(),
                              controller["strays"].get<std::uint64_t>()));
  row("reports", fmt::format("{}, {} of what no arm can do, silent for {:.1f} ms at most",
                             controller["reports"].get<std::uint64_t>(),
                             controller["bad_reports"].get<std::uint64_t>(),
                             controller["silence_max_ms"].get<double>()));
  row("faults", fmt::format("{}, connected {} times", controller["faults"].get<std::uint64_t>(),
                            controller["connections"].get<std::uint64_t>()));
  row(bus["interface"],
      fmt::format("{} frames out, {} in, {} + {} dropped, load {:.0f} %",
                  bus["tx"].get<std::uint64_t>(), bus["rx"].get<std::uint64_t>(),
                  bus["tx_dropped"].get<std::uint64_t>(), bus["rx_dropped"].get<std::uint64_t>(),
                  100 * bus["load_peak"].get<double>()));
  row("clock",
      fmt::format("{:.1f} ms late at most, {} steps missed; SCHED_FIFO {}",
                  realtime["late_max_ms"].get<double>(), realtime["missed"].get<std::uint64_t>(),
                  realtime["fifo"].get<std::string>()));
  return row.text;
}

}  // namespace pipewright::hil
