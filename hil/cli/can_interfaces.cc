// SPDX-License-Identifier: MIT
#include "hil/cli/can_interfaces.h"

#include <fmt/format.h>

namespace pipewright::hil {
namespace {

/// What can.log's writer may be behind by: two seconds of a full bus.
constexpr int kTapFrames = 8192;

}  // namespace

std::string CanInterfaces::Open(const std::vector<std::string>& interfaces, bool with_devices) {
  with_devices_ = with_devices;
  interfaces_.clear();
  for (const std::string& name : interfaces) {
    Interface& interface = interfaces_.emplace_back(name);
    std::vector<SocketCan*> sockets = {&interface.robot, &interface.tap};
    if (with_devices) {
      sockets.push_back(&interface.devices);
    }
    for (SocketCan* socket : sockets) {
      if (socket->Open(name) != Status::kOk) {
        return fmt::format("--bus {}: cannot open the interface: {}", name, socket->error_text());
      }
    }
    interface.tap.GrowReceiveQueue(kTapFrames);
  }
  return "";
}

RealtimePorts CanInterfaces::Ports() {
  RealtimePorts ports;
  ports.base = &interfaces_.front().robot_port;
  ports.arm = &interfaces_.back().robot_port;
  for (Interface& interface : interfaces_) {
    if (with_devices_) {
      ports.devices.push_back(&interface.devices_port);
    }
    ports.taps.push_back({&interface.tap_port, interface.name});
    ports.robot_sockets.push_back(&interface.robot);
    ports.tap_sockets.push_back(&interface.tap);
  }
  return ports;
}

}  // namespace pipewright::hil
