// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "hil/cli/virtual_run.h"
#include "hil/devices/port.h"
#include "platform/linux/depth_socket.h"
#include "platform/linux/socket_can.h"

namespace pipewright::hil {

/// The wires of a run in real time. Each port is used by one thread: the robot's by its control
/// thread, the devices' by the emulator's, the taps by the caller's. Frames are stamped with Now().
struct RealtimePorts {
  struct Tap {
    Port* port = nullptr;
    std::string name;  ///< of the interface, for can.log
  };

  Port* base = nullptr;
  Port* arm = nullptr;         ///< the base's: one bus for both
  std::vector<Port*> devices;  ///< as Emulator takes them; empty: the devices are elsewhere
  std::vector<Tap> taps;       ///< that hear everything
  /// Behind `base` and `arm`, and behind `taps`, where they are the kernel's: for what was lost.
  std::vector<SocketCan*> robot_sockets;
  std::vector<SocketCan*> tap_sockets;
  DepthSocket* camera = nullptr;  ///< where the devices are elsewhere; else none
};

/// The robot program on three threads and the machine's clock; the emulated devices, camera and
/// truth on two more, in steps of 1 ms; this thread writes can.log and plan.jsonl. The folder's
/// files are those of a virtual run, and run.json has "realtime" besides.
///
/// Without devices there is no plant here: what only the truth can tell is null in run.json and nan
/// in trace.csv, and depth frames come from ports.camera, or else the mission ends with a device
/// fault.
/// @returns run.json's object
nlohmann::ordered_json RunRealtime(const RealtimePorts& ports, const Scenario& scenario,
                                   const InspectionOptions& options, RunFolder& folder,
                                   const RunHooks& hooks);

}  // namespace pipewright::hil
