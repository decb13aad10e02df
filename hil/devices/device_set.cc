// SPDX-License-Identifier: MIT
#include "hil/devices/device_set.h"

#include <algorithm>
#include <cassert>

namespace pipewright::hil {

int DeviceNumber(const std::string& name) {
  if (name == "tracer") {
    return 0;
  }
  for (int i = 1; i <= kArmNodes; ++i) {
    if (name == "arm" + std::to_string(i)) {
      return i;
    }
  }
  return -1;
}

DeviceSetConfig TracerUf7Devices(const Vec<kArmNodes>& lower_rad, const Vec<kArmNodes>& upper_rad) {
  constexpr double kInside_rad = 1e-4;
  DeviceSetConfig config;
  for (int i = 0; i < kArmNodes; ++i) {
    Cia402Config& joint = config.joints[static_cast<std::size_t>(i)];
    joint.node_id = i + 1;
    joint.lower_rad = lower_rad(i) + kInside_rad;
    joint.upper_rad = upper_rad(i) - kInside_rad;
  }
  return config;
}

DeviceSet::DeviceSet(const DeviceSetConfig& config, const std::vector<Port*>& ports)
    : config_(config),
      ports_(ports),
      tracer_(config.tracer),
      joints_(config.joints.begin(), config.joints.end()) {
  assert(ports.size() == 1 || ports.size() == 2 || ports.size() == kDevices);
}

std::size_t DeviceSet::PortOfDevice(int device) const {
  return std::min(static_cast<std::size_t>(device), ports_.size() - 1);
}

bool DeviceSet::OnBus(int device, Time now) const {
  const auto i = static_cast<std::size_t>(device);
  const std::optional<Time>& from = config_.silent_from[i];
  return !config_.absent[i] && (!from || now < *from);
}

void DeviceSet::Receive(Time now) {
  can::Frame frame;
  for (std::size_t port = 0; port < ports_.size(); ++port) {
    while (ports_[port]->Receive(frame)) {
      for (int device = 0; device < kDevices; ++device) {
        if (PortOfDevice(device) != port || !OnBus(device, now)) {
          continue;
        }
        if (device == 0) {
          tracer_.OnFrame(frame, now);
        } else {
          joints_[static_cast<std::size_t>(device - 1)].OnFrame(frame, now);
        }
      }
    }
  }
}

void DeviceSet::Send(int device, Time now) {
  for (const can::Frame& frame : outbox_) {
    if (OnBus(device, now) && ports_[PortOfDevice(device)]->Send(frame) != Status::kOk) {
      ++send_failures_;
    }
  }
  outbox_.clear();
}

DeviceMotion DeviceSet::Step(Time now, const Vec<kArmNodes>& positions_rad) {
  for (int i = 0; i < kArmNodes; ++i) {
    joints_[static_cast<std::size_t>(i)].Measure(positions_rad(i));
  }
  Receive(now);
  DeviceMotion motion;
  if (!config_.absent[0]) {
    tracer_.Step(now, outbox_);
    motion.base = tracer_.motion();
    Send(0, now);
  }
  for (int i = 0; i < kArmNodes; ++i) {
    const auto joint = static_cast<std::size_t>(i);
    if (!config_.absent[joint + 1]) {
      joints_[joint].Step(now, outbox_);
      motion.joints_radps(i) = joints_[joint].velocity_radps();
      Send(i + 1, now);
    }
  }
  return motion;
}

}  // namespace pipewright::hil
