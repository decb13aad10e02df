// SPDX-License-Identifier: MIT
// The host's drivers and the emulated devices were written apart, from the same facts: here they
// meet on one wire.
#include <gtest/gtest.h>

#include <memory>

#include "hil/devices/device_set.h"
#include "hil/plant/plant.h"
#include "platform/can/loopback_bus.h"
#include "platform/drivers/arm_driver.h"
#include "platform/drivers/tracer_driver.h"

namespace pipewright::hil {
namespace {

using std::chrono::milliseconds;
using Joints = Vec<kArmNodes>;

struct Mission {
  explicit Mission(const std::vector<int>& absent = {}) {
    DeviceSetConfig config = TracerUf7Devices(plant.lower_rad(), plant.upper_rad());
    for (const int device : absent) {
      config.absent[static_cast<std::size_t>(device)] = true;
    }
    std::vector<Port*> ports;
    for (int i = 0; i < kDevices; ++i) {
      wires.push_back(std::make_unique<PortOf<can::LoopbackBus::Port>>(*bus.Attach()));
      ports.push_back(wires.back().get());
    }
    devices = std::make_unique<DeviceSet>(config, ports);
  }

  void Control() {
    can::Frame frame;
    while (host.Receive(frame)) {
      base.OnFrame(frame);
      arm.OnFrame(frame);
    }
    if (base.ready()) {
      EXPECT_EQ(base.Command(v_mps, omega_radps), Status::kOk);
    }
    if (arm.ready()) {
      EXPECT_EQ(arm.Command(qdot_radps), Status::kOk);
    }
    TxBatch out;
    base.Step(now, out);
    arm.Step(now, out);
    for (const can::Frame& f : out) {
      EXPECT_EQ(host.Send(f), Status::kOk);
    }
  }
  void Run(int ms, bool host_alive = true) {
    for (int i = 0; i < ms; ++i) {
      if (host_alive && (now.time_since_epoch() % milliseconds(10)).count() == 0) {
        Control();
      }
      motion = devices->Step(now, plant.joints_rad());
      plant.Step(milliseconds(1), motion.base.v_mps, motion.base.omega_radps, motion.joints_radps);
      now += milliseconds(1);
      bus.AdvanceTo(now);
    }
  }
  bool Ready() const { return base.ready() && arm.ready(); }

  can::LoopbackBus bus{500'000};
  can::LoopbackBus::Port& host = *bus.Attach();
  Plant plant{TracerUf7Description(), {}, Joints::Constant(0.3)};
  std::vector<std::unique_ptr<Port>> wires;
  std::unique_ptr<DeviceSet> devices;
  TracerDriver base;
  ArmDriver arm;
  DeviceMotion motion;
  double v_mps = 0;
  double omega_radps = 0;
  Joints qdot_radps = Joints::Zero();
  Time now{};
};

TEST(DriversAndDevices, AreReadyWithinThreeSecondsOnASharedBus) {
  Mission mission;
  mission.Run(3000);
  EXPECT_TRUE(mission.Ready()) << Name(mission.base.fault().problem) << ", arm "
                               << Name(mission.arm.fault().problem) << " node "
                               << mission.arm.fault().node << " detail " << std::hex
                               << mission.arm.fault().detail;
  EXPECT_LT(mission.bus.PeakLoad(), 0.9);
  EXPECT_LT((mission.arm.position_rad() - mission.plant.joints_rad()).norm(), 1e-5);
}

TEST(DriversAndDevices, MoveAsCommandedAndSayWhereTheyAre) {
  Mission mission;
  mission.Run(3000);
  ASSERT_TRUE(mission.Ready());
  mission.v_mps = 0.2;
  mission.omega_radps = -0.1;
  mission.qdot_radps = Joints::LinSpaced(-0.3, 0.3);
  mission.Run(2000);
  EXPECT_NEAR(mission.motion.base.v_mps, 0.2, 5e-4);
  EXPECT_NEAR(mission.motion.base.omega_radps, -0.1, 5e-4);
  EXPECT_LT((mission.motion.joints_radps - mission.qdot_radps).norm(), 1e-5);
  EXPECT_LT((mission.arm.velocity_radps() - mission.qdot_radps).norm(), 1e-5);
  // The reading is at most two cycles old.
  EXPECT_LT((mission.arm.position_rad() - mission.plant.joints_rad()).norm(), 0.03);
  EXPECT_NEAR(mission.base.odometer().left_m + mission.base.odometer().right_m,
              2 * mission.plant.base().x_m, 0.05);
  EXPECT_LE(mission.bus.PeakLoad(), 0.9);

  mission.base.Stop();
  mission.arm.Stop();
  mission.Run(2500);
  EXPECT_EQ(mission.base.phase(), DriverPhase::kStopped);
  EXPECT_EQ(mission.arm.phase(), DriverPhase::kStopped);
  EXPECT_EQ(mission.motion.base.v_mps, 0);
  EXPECT_EQ(mission.motion.joints_radps, Joints::Zero());
  for (int i = 0; i < kArmNodes; ++i) {
    EXPECT_EQ(mission.devices->joint(i).drive_state(), DriveState::kSwitchOnDisabled);
  }
}

TEST(DriversAndDevices, ADeadHostLeavesARobotAtRest) {
  Mission mission;
  mission.Run(3000);
  ASSERT_TRUE(mission.Ready());
  mission.v_mps = 0.3;
  mission.qdot_radps = Joints::Constant(0.4);
  mission.Run(1000);
  mission.Run(1000, /*host_alive=*/false);
  EXPECT_EQ(mission.motion.base.v_mps, 0);
  EXPECT_EQ(mission.motion.joints_radps, Joints::Zero());
  for (int i = 0; i < kArmNodes; ++i) {
    EXPECT_EQ(mission.devices->joint(i).drive_state(), DriveState::kFault);
  }
  EXPECT_EQ(mission.devices->tracer().watchdog_trips(), 1);
}

TEST(DriversAndDevices, EachDeviceThatFallsSilentIsNamed) {
  for (const int device : {0, 1, 4, 7}) {
    SCOPED_TRACE(device);
    Mission mission;
    mission.Run(3000);
    ASSERT_TRUE(mission.Ready());
    mission.devices->Silence(device, mission.now);
    mission.Run(400);
    if (device == 0) {
      EXPECT_EQ(mission.base.fault().problem, Problem::kStateStale);
      EXPECT_TRUE(mission.arm.ready());
    } else {
      EXPECT_EQ(mission.arm.phase(), DriverPhase::kFault);
      EXPECT_EQ(mission.arm.fault().node, device);
      EXPECT_TRUE(mission.base.ready());
    }
  }
}

TEST(DriversAndDevices, AnAbsentDeviceIsNamed) {
  Mission no_base({0});
  no_base.Run(6000);
  EXPECT_EQ(no_base.base.fault().problem, Problem::kNotHeard);
  EXPECT_EQ(no_base.base.fault().status, Status::kTimeout);
  Mission no_elbow({5});
  no_elbow.Run(6000);
  EXPECT_EQ(no_elbow.arm.fault().problem, Problem::kNotHeard);
  EXPECT_EQ(no_elbow.arm.fault().node, 5);
}

TEST(DriversAndDevices, TheEmergencyStopAndADriveFaultReachTheDrivers) {
  Mission mission;
  mission.Run(3000);
  ASSERT_TRUE(mission.Ready());
  mission.v_mps = 0.3;
  mission.Run(500);
  mission.devices->tracer().PressEmergencyStop(true);
  mission.devices->joint(5).RaiseInternalFault(0x2310);
  mission.Run(300);
  EXPECT_TRUE(mission.base.emergency_stop());
  EXPECT_EQ(mission.base.fault().problem, Problem::kEmergencyStop);
  EXPECT_EQ(mission.arm.fault().node, 6);
  EXPECT_EQ(mission.arm.last_emergency(5), 0x2310U);
  EXPECT_EQ(mission.motion.base.v_mps, 0);
}

TEST(DriversAndDevices, AJointNeverReachesItsHardStop) {
  Mission mission;
  mission.Run(3000);
  ASSERT_TRUE(mission.Ready());
  for (const double speed : {3.0, -3.0}) {
    mission.qdot_radps.setConstant(speed);
    mission.Run(5000);
  }
  EXPECT_EQ(mission.plant.hard_stops(), 0);
  EXPECT_LE((mission.plant.joints_rad() - mission.plant.upper_rad()).maxCoeff(), 0);
  EXPECT_GE((mission.plant.joints_rad() - mission.plant.lower_rad()).minCoeff(), 0);
}

}  // namespace
}  // namespace pipewright::hil
