// SPDX-License-Identifier: MIT
// Both drivers against the emulated devices, which share only the frame tables with them, over a
// bus with its delays.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "hil/devices/device_set.h"
#include "platform/can/loopback_bus.h"
#include "platform/drivers/arm_driver.h"
#include "platform/drivers/tracer_driver.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

/// The robot on one shared bus of 500 kbit/s, each device with a port of its own, and its host.
class OverTheBus : public testing::Test {
 protected:
  explicit OverTheBus(hil::DeviceSetConfig config = Config()) {
    std::vector<hil::Port*> ports;
    for (int i = 0; i < hil::kDevices; ++i) {
      ports_.push_back(std::make_unique<hil::PortOf<can::LoopbackBus::Port>>(*bus_->Attach()));
      ports.push_back(ports_.back().get());
    }
    devices_ = std::make_unique<hil::DeviceSet>(config, ports);
  }
  static hil::DeviceSetConfig Config() {
    return hil::TracerUf7Devices(ArmVector::Constant(-3), ArmVector::Constant(3));
  }

  void ControlCycle() {
    can::Frame frame;
    while (host_.Receive(frame)) {
      arm_.OnFrame(frame);
      base_.OnFrame(frame);
    }
    if (arm_.ready()) {
      ASSERT_EQ(arm_.Command(qdot_), Status::kOk);
    }
    if (base_.ready()) {
      ASSERT_EQ(base_.Command(v_, omega_), Status::kOk);
    }
    TxBatch out;
    arm_.Step(bus_->now(), out);
    base_.Step(bus_->now(), out);
    for (const can::Frame& f : out) {
      ASSERT_EQ(host_.Send(f), Status::kOk);
    }
  }
  void Run(Duration time) {
    for (const Time end = bus_->now() + time; bus_->now() < end;) {
      const Time now = bus_->now();
      if (host_alive_ && now.time_since_epoch() % 10ms == Duration::zero()) {
        ControlCycle();
      }
      motion_ = devices_->Step(now, joints_);
      joints_ += motion_.joints_radps * 1e-3;
      bus_->AdvanceTo(now + 1ms);
    }
  }
  bool Ready() const { return arm_.ready() && base_.ready(); }

  std::unique_ptr<can::LoopbackBus> bus_ = std::make_unique<can::LoopbackBus>(500'000);
  can::LoopbackBus::Port& host_ = *bus_->Attach();
  std::vector<std::unique_ptr<hil::Port>> ports_;
  std::unique_ptr<hil::DeviceSet> devices_;
  hil::DeviceMotion motion_;
  ArmVector joints_ = ArmVector::Zero();
  ArmDriver arm_;
  TracerDriver base_;
  ArmVector qdot_ = ArmVector::Zero();
  double v_ = 0;
  double omega_ = 0;
  bool host_alive_ = true;
};

TEST_F(OverTheBus, ComesUpMovesAndStops) {
  Run(2s);
  ASSERT_TRUE(Ready()) << Name(arm_.fault().problem) << arm_.fault().node << ", "
                       << Name(base_.fault().problem);
  qdot_ << 0.1, -0.2, 0.3, -0.1, 0.2, -0.3, 0.1;
  v_ = 0.2;
  omega_ = -0.1;
  Run(2s);
  EXPECT_LT((motion_.joints_radps - qdot_).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((arm_.velocity_radps() - qdot_).cwiseAbs().maxCoeff(), 1e-6);
  // Feedback is what the joints were at the last SYNC but one: 20 ms, and a step of the devices.
  EXPECT_LT((arm_.position_rad() - joints_).cwiseAbs().maxCoeff(), 0.3 * 0.025);
  EXPECT_NEAR(base_.twist().v_mps, 0.2, 1e-9);
  EXPECT_NEAR(base_.twist().omega_radps, -0.1, 1e-9);
  EXPECT_LT(bus_->now() - arm_.feedback_stamp(), 20ms);

  arm_.Stop();
  base_.Stop();
  Run(2s);
  EXPECT_EQ(arm_.phase(), DriverPhase::kStopped);
  EXPECT_EQ(base_.phase(), DriverPhase::kStopped);
  EXPECT_EQ(motion_.joints_radps.cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(motion_.base.v_mps, 0);
  EXPECT_FALSE(devices_->tracer().can_mode());
}

TEST_F(OverTheBus, ItsTrafficFitsASharedBusAndNothingIsLost) {
  Run(5s);
  ASSERT_TRUE(Ready());
  // Nominal bits give 40 %, worst-case stuffing 49 %; real stuffing lies between.
  EXPECT_GT(bus_->Load(), 0.40);
  EXPECT_LT(bus_->PeakLoad(), 0.55);
  EXPECT_EQ(host_.counters().tx_dropped, 0U);
  EXPECT_EQ(host_.counters().rx_dropped, 0U);
  EXPECT_EQ(devices_->send_failures(), 0);
  EXPECT_EQ(devices_->tracer().rejected(), 0);
  EXPECT_EQ(arm_.rx_counters().wrong_length + arm_.rx_counters().out_of_range, 0U);
  EXPECT_EQ(base_.rx_counters().wrong_length + base_.rx_counters().out_of_range, 0U);
}

TEST_F(OverTheBus, ADriveThatFallsSilentStopsTheWholeArm) {
  Run(2s);
  ASSERT_TRUE(Ready());
  qdot_.setConstant(0.3);
  Run(500ms);
  devices_->Silence(3, bus_->now());
  Run(1s);
  EXPECT_EQ(arm_.phase(), DriverPhase::kFault);
  EXPECT_EQ(arm_.fault().node, 3);
  EXPECT_EQ(arm_.fault().problem, Problem::kStateStale);
  EXPECT_EQ(motion_.joints_radps.cwiseAbs().maxCoeff(), 0);  // the silent one by its own watchdog
}

TEST_F(OverTheBus, AHostThatDiesLeavesTheRobotAtRest) {
  Run(2s);
  ASSERT_TRUE(Ready());
  qdot_.setConstant(0.3);
  v_ = 0.5;
  Run(1s);
  ASSERT_GT(motion_.base.v_mps, 0.4);
  host_alive_ = false;
  Run(1500ms);  // 500 ms watchdogs, then their ramps
  EXPECT_EQ(motion_.joints_radps.cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(motion_.base.v_mps, 0);
  EXPECT_EQ(devices_->tracer().watchdog_trips(), 1);
}

TEST_F(OverTheBus, AfterTheHostComesBackTheArmIsResetAndEnabledAgain) {
  Run(2s);
  ASSERT_TRUE(Ready());
  qdot_.setConstant(0.1);
  Run(200ms);
  host_alive_ = false;
  Run(1s);
  host_alive_ = true;
  qdot_.setZero();
  arm_ = ArmDriver();
  base_ = TracerDriver();
  Run(3s);
  EXPECT_TRUE(Ready()) << Name(arm_.fault().problem) << arm_.fault().node;
}

TEST_F(OverTheBus, AnEmergencyStopIsLatchedAndLeftByAnOperatorsReset) {
  Run(2s);
  ASSERT_TRUE(Ready());
  v_ = 0.3;
  Run(500ms);
  devices_->tracer().PressEmergencyStop(true);
  Run(1s);
  EXPECT_EQ(base_.fault().problem, Problem::kEmergencyStop);
  EXPECT_TRUE(base_.emergency_stop());
  EXPECT_EQ(motion_.base.v_mps, 0);
  devices_->tracer().PressEmergencyStop(false);
  Run(1s);
  EXPECT_EQ(base_.phase(), DriverPhase::kFault);
  EXPECT_EQ(motion_.base.v_mps, 0);
  base_.Reset();
  Run(1s);
  EXPECT_TRUE(base_.ready());
}

class WithoutJoint6 : public OverTheBus {
 protected:
  WithoutJoint6()
      : OverTheBus([] {
          hil::DeviceSetConfig config = Config();
          config.absent[6] = true;
          return config;
        }()) {}
};

TEST_F(WithoutJoint6, AnAbsentDriveIsNamedAndTheArmNeverEnabled) {
  Run(6s);
  EXPECT_EQ(arm_.fault().problem, Problem::kNotHeard);
  EXPECT_EQ(arm_.fault().status, Status::kTimeout);
  EXPECT_EQ(arm_.fault().node, 6);
  EXPECT_EQ(motion_.joints_radps.cwiseAbs().maxCoeff(), 0);
}

}  // namespace
}  // namespace pipewright
