// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "hil/cli/wire_port.h"
#include "hil/depth_stream/depth_sender.h"
#include "hil/devices/tracer_device.h"
#include "hil/world/scenario.h"

namespace pipewright::hil {

/// What a person asks of `pipewright emulate`.
struct EmulationOptions {
  std::string scenario = "pipes3";
  std::optional<std::string> faults;
  std::uint64_t seed = 1;
  std::string bus;       ///< the base's interface; the arm's, too, where it has none of its own
  std::string arm_bus;   ///< empty: the base's
  std::string camera;    ///< path of the depth stream; empty: nobody looks
  double rate_hz = 100;  ///< at which the host will ask the arm
  TracerConfig tracer;
  bool ask_fifo = true;
  std::optional<double> time_limit_s;
  bool json = false;
};

/// How an emulation is going, for a person who waits.
struct EmulationProgress {
  Time now{};
  bool base_in_can_mode = false;
  int joints_enabled = 0;
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
  int contacts = 0;
};

struct EmulationHooks {
  std::function<void()> started;                           ///< the devices have booted
  std::function<void(const EmulationProgress&)> progress;  ///< once a second
  std::function<bool()> interrupted;
};

/// Tracer and UF7 on the kernel's wires in real time, in steps of 1 ms, at SCHED_FIFO where that is
/// granted; beside them, on a thread of its own, the camera, if anyone reads it. A step that is
/// late is made up for; after more than 100 ms the devices have stood still instead, and it counts
/// as a stall.
/// @param wires   open: the one for all, or the base's and the arm's
/// @param camera  open, or of no path
/// @returns the figures. "stop_reason": interrupted, time_limit, or bus_gone when an interface was
///          taken out of the system
nlohmann::ordered_json RunEmulation(const Scenario& scenario, const EmulationOptions& options,
                                    std::deque<WirePort>& wires, DepthSender& camera,
                                    const EmulationHooks& hooks);

/// The same figures as a short table for people.
std::string EmulationTable(const nlohmann::ordered_json& run);

}  // namespace pipewright::hil
