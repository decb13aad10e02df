// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "hil/cli/wire_port.h"
#include "hil/xarm/xarm_gateway.h"

namespace pipewright::hil {

/// What a person asks of `pipewright gateway`.
struct GatewayOptions {
  std::string controller;  ///< as given: a name or an address
  std::string bus;
  XarmGatewayConfig config;
  int priority =
      75;  ///< of SCHED_FIFO: below a robot program's control thread on the same computer
  bool ask_fifo = true;
  std::optional<double> time_limit_s;
  bool json = false;
};

/// How it is going, for a person who waits.
struct GatewayProgress {
  Time now{};
  XarmPhase phase = XarmPhase::kConnecting;
  std::string trouble;
  int joints_enabled = 0;
  std::uint64_t velocities = 0;
  XarmVector position_rad = XarmVector::Zero();
  bool measured = false;
  bool bus_gone = false;
};

struct GatewayHooks {
  std::function<void(const GatewayProgress&)> progress;  ///< each second, and at each new phase
  std::function<bool()> interrupted;
};

/// The arm's controller on the bus, in steps of 1 ms of real time, at SCHED_FIFO where that is
/// granted. When it ends while the arm is at work, the arm is told to stop, and the host that it
/// was.
/// @param wire  open
/// @returns the figures. "stop_reason": interrupted, time_limit, refused (not a controller to work
///          with) or bus_gone (the interface was taken out of the system)
nlohmann::ordered_json RunGateway(const GatewayOptions& options, WirePort& wire,
                                  const GatewayHooks& hooks);

/// The same figures as a short table for people.
std::string GatewayTable(const nlohmann::ordered_json& run);

}  // namespace pipewright::hil
