// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "hil/devices/cia402_node.h"
#include "hil/devices/port.h"
#include "hil/devices/tracer_device.h"
#include "platform/core/frames.h"
#include "platform/core/time.h"

namespace pipewright::hil {

inline constexpr int kArmNodes = 7;
/// Devices by number: 0 the Tracer, 1 to 7 the arm's joints.
inline constexpr int kDevices = 1 + kArmNodes;

/// "tracer", "arm1" ... "arm7"; -1 for any other name.
int DeviceNumber(const std::string& name);

struct DeviceSetConfig {
  TracerConfig tracer;
  std::array<Cia402Config, kArmNodes> joints;
  /// Left out of the robot: never on the bus, never moves.
  std::array<bool, kDevices> absent{};
  /// Cut off the bus from this time on, both ways. Its own watchdog then stops it.
  std::array<std::optional<Time>, kDevices> silent_from{};
};

/// The UF7's seven joints as nodes 1 to 7 with soft limits just inside the given hard ones.
DeviceSetConfig TracerUf7Devices(const Vec<kArmNodes>& lower_rad, const Vec<kArmNodes>& upper_rad);

/// What the devices do to the robot's bodies until the next step.
struct DeviceMotion {
  BaseMotion base;
  Vec<kArmNodes> joints_radps = Vec<kArmNodes>::Zero();
};

/// Every device of the robot, on its wires.
///
///   while (running) {                                    // each 1 ms
///     const DeviceMotion m = devices.Step(now, plant.joints_rad());
///     plant.Step(1ms, m.base.v_mps, m.base.omega_radps, m.joints_radps);
///     bus.AdvanceTo(now += 1ms);
///   }
class DeviceSet {
 public:
  /// ports: one (all devices share it), two (the Tracer's, the arm's) or kDevices (one each);
  /// assert otherwise. Ports must outlive the set.
  DeviceSet(const DeviceSetConfig& config, const std::vector<Port*>& ports);

  /// Reads every port dry, steps every device, sends what they say.
  DeviceMotion Step(Time now, const Vec<kArmNodes>& positions_rad);

  TracerDevice& tracer() { return tracer_; }
  Cia402Node& joint(int i) { return joints_[i]; }  ///< 0-based
  const TracerDevice& tracer() const { return tracer_; }
  const Cia402Node& joint(int i) const { return joints_[i]; }
  void Silence(int device, Time from) { config_.silent_from[device] = from; }
  /// Frames a port did not take.
  int send_failures() const { return send_failures_; }

 private:
  bool OnBus(int device, Time now) const;
  void Receive(Time now);
  void Send(int device, Time now);
  std::size_t PortOfDevice(int device) const;

  DeviceSetConfig config_;
  std::vector<Port*> ports_;
  TracerDevice tracer_;
  std::vector<Cia402Node> joints_;
  std::vector<can::Frame> outbox_;
  int send_failures_ = 0;
};

}  // namespace pipewright::hil
