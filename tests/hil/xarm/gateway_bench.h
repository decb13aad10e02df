// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <memory>
#include <vector>

#include "hil/xarm/xarm_controller.h"
#include "hil/xarm/xarm_gateway.h"
#include "platform/can/loopback_bus.h"
#include "platform/drivers/arm_driver.h"

namespace pipewright::hil {

/// The host's driver, the gateway and an emulated controller: CAN in virtual time, and real TCP on
/// 127.0.0.1. What was sent has come before time goes on, so that the kernel's pace is no matter.
class GatewayBench {
 public:
  static constexpr Duration kTick = std::chrono::milliseconds(1);

  explicit GatewayBench(const XarmControllerConfig& arm = {},
                        XarmReportKind report = XarmReportKind::kReal)
      : controller(arm) {
    open_error = controller.Open();
    config.controller.address = "127.0.0.1";
    config.controller.request_port = controller.request_port();
    config.controller.report = report;
    config.controller.report_port = controller.report_port(report);
    Restart();
  }

  /// The gateway as another process would find it.
  void Restart() { gateway = std::make_unique<XarmGateway>(config, gateway_port_); }

  void Tick() {
    if (host_alive && (now.time_since_epoch() % std::chrono::milliseconds(10)).count() == 0) {
      Control();
    }
    if (gateway) {
      gateway->Step(now);
      for (int i = 0; i < kPatience && gateway->client().connecting(); ++i) {
        usleep(kPause_us);
        gateway->Step(now);
      }
    }
    Settle();
    controller.Step(now);
    Settle();
    now += kTick;
    bus.AdvanceTo(now);
    can::Frame frame;
    while (tap_.Receive(frame)) {
      wire.push_back(frame);
    }
  }
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) {
      Tick();
    }
  }
  /// Until it holds, `ms` at most.
  template <typename Condition>
  bool RunUntil(int ms, const Condition& holds) {
    for (int i = 0; i < ms && !holds(); ++i) {
      Tick();
    }
    return holds();
  }
  bool BeReady(int ms = 4000) {
    return RunUntil(ms, [&] { return driver.ready(); });
  }

  /// EMCY codes that each node sent since `from` (an index of `wire`), without "no error".
  std::vector<std::uint32_t> Emergencies(int node, std::size_t from = 0) const {
    std::vector<std::uint32_t> codes;
    for (std::size_t i = from; i < wire.size(); ++i) {
      const auto emergency = can::Decode(can::kEmergency, wire[i]);
      if (emergency.ok() && wire[i].id == can::kEmergency.head.id + static_cast<unsigned>(node) &&
          emergency->code != 0) {
        codes.push_back(emergency->code);
        vendor = emergency->vendor;
      }
    }
    return codes;
  }
  bool All(DriveState state) const {
    for (int i = 0; i < kXarmJoints; ++i) {
      if (gateway->node(i).drive_state() != state) {
        return false;
      }
    }
    return true;
  }
  /// Of the requests that the controller heard from `from` on.
  int Heard(XarmRegister reg, std::size_t from = 0) const {
    int count = 0;
    for (std::size_t i = from; i < controller.heard().size(); ++i) {
      count += controller.heard()[i].reg() == reg ? 1 : 0;
    }
    return count;
  }

  XarmController controller;
  XarmGatewayConfig config;
  std::unique_ptr<XarmGateway> gateway;
  can::LoopbackBus bus{can::kArmBitrate};
  ArmDriver driver;
  ArmVector qdot_radps = ArmVector::Zero();
  bool host_alive = true;
  Time now{};
  std::vector<can::Frame> wire;
  std::string open_error;
  mutable std::uint32_t vendor = 0;  ///< of the last EMCY that Emergencies() met

 private:
  static constexpr int kPatience = 4000;
  static constexpr int kPause_us = 50;

  void Control() {
    can::Frame frame;
    while (host_.Receive(frame)) {
      driver.OnFrame(frame);
    }
    if (driver.ready()) {
      (void)driver.Command(qdot_radps);
    }
    TxBatch out;
    driver.Step(now, out);
    for (const can::Frame& f : out) {
      (void)host_.Send(f);
    }
  }
  /// Until all that either side has sent has come to the other, where both are connected.
  void Settle() {
    if (!gateway) {
      return;
    }
    const bool anew = gateway->counters().connections != connections_;
    connections_ = gateway->counters().connections;
    for (int i = 0; i < kPatience && gateway->client().up() && !Settled(); ++i) {
      usleep(kPause_us);
      if (anew || controller.clients() > 2) {
        controller.Step(now);  // takes the new connections, and notes that the old have ended
      }
    }
  }
  bool Settled() const {
    const XarmClient& client = gateway->client();
    const int requests = config.controller.request_port;
    const int reports = config.controller.report_port;
    return controller.clients() == 0 ||
           (controller.clients() == 2 && client.requests().sent() == controller.arrived(requests) &&
            client.requests().arrived() == controller.sent(requests) &&
            client.reports().arrived() == controller.sent(reports));
  }

  std::uint64_t connections_ = 0;
  can::LoopbackBus::Port& host_ = *bus.Attach();
  PortOf<can::LoopbackBus::Port> gateway_port_{*bus.Attach()};
  can::LoopbackBus::Port& tap_ = *bus.AttachListener();
};

inline XarmVector Start() {
  XarmVector start;
  start << 0.1, -0.9, 0.2, 0.5, -0.3, -0.4, 0.6;
  return start;
}

inline XarmControllerConfig Arm() { return {.start_rad = Start()}; }

/// At work, every joint at its own speed.
inline void Move(GatewayBench& bench) {
  ASSERT_EQ(bench.open_error, "");
  ASSERT_TRUE(bench.BeReady()) << Name(bench.driver.fault().problem) << ", "
                               << Name(bench.gateway->phase()) << ", " << bench.gateway->trouble();
  bench.qdot_radps = ArmVector::LinSpaced(-0.3, 0.3);
  bench.qdot_radps(3) = 0.2;
  bench.Run(400);
  ASSERT_TRUE(bench.driver.ready()) << bench.gateway->trouble();
  ASSERT_LT((bench.controller.velocity_radps() - bench.qdot_radps).norm(), 1e-6);
}

/// That all seven nodes said this once since `from`, and are in fault.
inline void ExpectFault(const GatewayBench& bench, std::uint32_t code, std::size_t from) {
  EXPECT_TRUE(bench.All(DriveState::kFault)) << bench.gateway->trouble();
  for (int node = 1; node <= kXarmJoints; ++node) {
    EXPECT_EQ(bench.Emergencies(node, from), std::vector{code}) << "node " << node;
  }
}

/// After an operator's word, the arm obeys again.
inline void ExpectRecovery(GatewayBench& bench) {
  bench.driver.Reset();
  ASSERT_TRUE(bench.BeReady()) << Name(bench.driver.fault().problem) << ", "
                               << bench.gateway->trouble();
  bench.qdot_radps.setConstant(0.1);
  bench.Run(200);
  EXPECT_LT((bench.controller.velocity_radps() - bench.qdot_radps).norm(), 1e-6);
}

}  // namespace pipewright::hil
