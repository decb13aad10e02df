// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "hil/devices/device_set.h"
#include "hil/plant/plant.h"
#include "platform/can/loopback_bus.h"
#include "platform/robot/uf7.h"

namespace pipewright::test {

inline constexpr Duration kTick = std::chrono::milliseconds(1);

/// A velocity command as its bytes say, read here by hand.
struct SentTwist {
  Time stamp{};
  int v_mmps = 0;
  int omega_mradps = 0;
};
struct SentJoint {
  Time stamp{};
  int joint = 0;  ///< 0 to 6
  std::int32_t velocity_uradps = 0;
};

/// The emulated devices and the bodies they move, on one bus of 500 kbit/s or on two, with a
/// listener that keeps every velocity command that goes over the wire.
class DeviceBench {
 public:
  explicit DeviceBench(bool shared = false) {
    for (const int i : {0, 1}) {
      robot_[i] = shared && i == 1 ? robot_[0] : bus_[i].Attach();
      device_[i] = shared && i == 1 ? device_[0] : bus_[i].Attach();
      tap_[i] = bus_[i].AttachListener();
    }
    ports_.push_back(std::make_unique<hil::PortOf<can::LoopbackBus::Port>>(*device_[0]));
    std::vector<hil::Port*> ports = {ports_[0].get()};
    if (!shared) {
      ports_.push_back(std::make_unique<hil::PortOf<can::LoopbackBus::Port>>(*device_[1]));
      ports.push_back(ports_[1].get());
    }
    devices_ = std::make_unique<hil::DeviceSet>(
        hil::TracerUf7Devices(plant_.lower_rad(), plant_.upper_rad()), ports);
  }

  can::LoopbackBus::Port& base() { return *robot_[0]; }
  can::LoopbackBus::Port& arm() { return *robot_[1]; }
  const can::LoopbackBus& bus(int i) const { return bus_[i]; }
  /// Another node, of nobody's.
  can::LoopbackBus::Port* Attach(int bus) { return bus_[bus].Attach(); }
  hil::DeviceSet& devices() { return *devices_; }
  const hil::Plant& plant() const { return plant_; }
  const hil::DeviceMotion& motion() const { return motion_; }
  Time now() const { return now_; }
  bool CycleDue() const {
    return (now_.time_since_epoch() % std::chrono::milliseconds(10)).count() == 0;
  }

  void Tick() {
    motion_ = devices_->Step(now_, plant_.joints_rad());
    plant_.Step(kTick, motion_.base.v_mps, motion_.base.omega_radps, motion_.joints_radps);
    now_ += kTick;
    can::Frame frame;
    for (const int i : {0, 1}) {
      bus_[i].AdvanceTo(now_);
      while (tap_[i]->Receive(frame)) {
        Keep(frame);
      }
    }
  }
  /// The link poses, as a camera wants them.
  std::vector<Isometry3d> Links() const {
    std::vector<Isometry3d> links;
    for (int i = 0; i < plant_.link_count(); ++i) {
      links.push_back(plant_.X_WL(i));
    }
    return links;
  }
  bool AtRest() const {
    return motion_.base.v_mps == 0 && motion_.base.omega_radps == 0 &&
           motion_.joints_radps.isZero(0);
  }

  std::vector<SentTwist> twists;
  std::vector<SentJoint> joints;

 private:
  void Keep(const can::Frame& f) {
    if (f.id == 0x111) {  // high byte first
      twists.push_back({f.stamp, static_cast<std::int16_t>(f.data[0] << 8 | f.data[1]),
                        static_cast<std::int16_t>(f.data[2] << 8 | f.data[3])});
    } else if (0x201 <= f.id && f.id <= 0x207) {  // controlword, then velocity, low byte first
      const std::uint32_t bits = f.data[2] | f.data[3] << 8 | f.data[4] << 16 |
                                 static_cast<std::uint32_t>(f.data[5]) << 24;
      joints.push_back({f.stamp, static_cast<int>(f.id) - 0x201, static_cast<std::int32_t>(bits)});
    }
  }

  std::array<can::LoopbackBus, 2> bus_{can::LoopbackBus(500'000), can::LoopbackBus(1'000'000)};
  std::array<can::LoopbackBus::Port*, 2> robot_{};
  std::array<can::LoopbackBus::Port*, 2> device_{};
  std::array<can::LoopbackBus::Port*, 2> tap_{};
  hil::Plant plant_{hil::TracerUf7Description(), {}, HomeJoints(TracerUf7())};
  std::vector<std::unique_ptr<hil::Port>> ports_;
  std::unique_ptr<hil::DeviceSet> devices_;
  hil::DeviceMotion motion_;
  Time now_{};
};

}  // namespace pipewright::test
