// SPDX-License-Identifier: MIT
#include "hil/devices/device_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "node_bench.h"
#include "platform/can/arm_startup.h"
#include "platform/can/loopback_bus.h"
#include "platform/can/tracer.h"
#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

using std::chrono::milliseconds;
using Joints = Vec<kArmNodes>;

/// The robot's devices on one loopback bus, the plainest plant, and a host that is the test.
struct Robot {
  explicit Robot(DeviceSetConfig config = Config(), int ports = 1) : host(*bus.Attach()) {
    for (int i = 0; i < ports; ++i) {
      wires.push_back(std::make_unique<PortOf<can::LoopbackBus::Port>>(*bus.Attach()));
      port_pointers.push_back(wires.back().get());
    }
    devices = std::make_unique<DeviceSet>(config, port_pointers);
  }
  static DeviceSetConfig Config() {
    return TracerUf7Devices(Joints::Constant(-2), Joints::Constant(2));
  }
  void Tick() {
    motion = devices->Step(now, joints);
    joints += motion.joints_radps * 1e-3;
    now += milliseconds(1);
    bus.AdvanceTo(now);
    can::Frame frame;
    while (host.Receive(frame)) {
      heard.push_back(frame);
    }
  }
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) {
      Tick();
    }
  }
  void Say(const can::Frame& frame) { EXPECT_EQ(host.Send(frame), Status::kOk); }
  bool Heard(std::uint32_t id) const {
    return std::any_of(heard.begin(), heard.end(),
                       [id](const can::Frame& f) { return f.id == id; });
  }

  can::LoopbackBus bus{1'000'000};
  can::LoopbackBus::Port& host;
  std::vector<std::unique_ptr<Port>> wires;
  std::vector<Port*> port_pointers;
  std::unique_ptr<DeviceSet> devices;
  DeviceMotion motion;
  Joints joints = Joints::Zero();
  Time now{};
  std::vector<can::Frame> heard;
};

/// Every step of the start-up that driver and drives agreed on, at every node.
void StartArm(Robot& robot) {
  for (const can::StartupStep& step : can::kArmStartup) {
    robot.heard.clear();
    for (int node = 1; node <= kArmNodes; ++node) {
      const std::uint32_t value = step.ValueFor(node);
      const can::Sdo request = step.kind == can::StepKind::kWrite
                                   ? can::DownloadRequest(step.object, step.bytes, value)
                                   : can::UploadRequest(step.object);
      robot.Say(*can::Encode(can::kSdoRequest, request, node));
    }
    robot.Run(6);
    int answers = 0;
    for (const can::Frame& frame : robot.heard) {
      const int node = can::NodeOf(can::kSdoResponse.head, frame.id);
      if (node < 1) {
        continue;
      }
      ++answers;
      const can::SdoMeaning meaning = can::Meaning(*can::Decode(can::kSdoResponse, frame), true);
      EXPECT_EQ(meaning.object, step.object);
      const std::uint32_t value = step.ValueFor(node);
      switch (step.kind) {
        case can::StepKind::kExpect:
          EXPECT_EQ(meaning.value, value);
          break;
        case can::StepKind::kExpectBits:
          EXPECT_EQ(meaning.value & value, value);
          break;
        case can::StepKind::kWrite:
          EXPECT_EQ(meaning.kind, can::SdoKind::kDownloadResponse)
              << std::hex << step.object.index << ":" << step.object.subindex;
          break;
      }
    }
    ASSERT_EQ(answers, kArmNodes);
  }
  robot.Say(Bytes(0x000, {0x01, 0x00}));
  robot.Run(2);
}

void Cycle(Robot& robot, std::uint32_t word, double velocity_radps) {
  for (int node = 1; node <= kArmNodes; ++node) {
    robot.Say(*can::Encode(can::kJointCommand, can::JointCommand{word, velocity_radps}, node));
  }
  robot.Say(Bytes(0x080, {}));
  robot.Say(Bytes(0x77F, {0x05}));
  robot.Run(10);
}

void Enable(Robot& robot) {
  robot.Run(150);
  StartArm(robot);
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
    Cycle(robot, word, 0);
  }
  for (int i = 0; i < kArmNodes; ++i) {
    ASSERT_EQ(robot.devices->joint(i).drive_state(), DriveState::kOperationEnabled);
  }
}

TEST(DeviceSet, TheAgreedStartUpEnablesAllJointsOnAnyWiring) {
  for (const int ports : {1, 2, 8}) {
    SCOPED_TRACE(ports);
    Robot robot(Robot::Config(), ports);
    Enable(robot);
    for (int i = 0; i < 20; ++i) {
      Cycle(robot, 0x0F, 0.1 * i);
    }
    EXPECT_TRUE(robot.motion.joints_radps.isApproxToConstant(1.9, 1e-9));
    EXPECT_EQ(robot.devices->send_failures(), 0);
    for (std::uint32_t node = 1; node <= 7; ++node) {
      EXPECT_TRUE(robot.Heard(0x180 + node));
      EXPECT_TRUE(robot.Heard(0x280 + node));
      EXPECT_FALSE(robot.Heard(0x080 + node));
    }
  }
}

TEST(DeviceSet, BaseAndArmMoveTogether) {
  Robot robot;
  Enable(robot);
  robot.Say(Bytes(0x421, {1}));
  for (int i = 0; i < 60; ++i) {
    robot.Say(*can::Encode(can::kBaseTwistCommand, can::BaseTwistCommand{0.3, -0.2}));
    Cycle(robot, 0x0F, 0.25);
  }
  EXPECT_NEAR(robot.motion.base.v_mps, 0.3, 1e-12);
  EXPECT_NEAR(robot.motion.base.omega_radps, -0.2, 1e-12);
  EXPECT_TRUE(robot.motion.joints_radps.isApproxToConstant(0.25, 1e-9));
}

TEST(DeviceSet, ASilentDeviceIsNotHeardAndStopsByItself) {
  Robot robot;
  Enable(robot);
  robot.Say(Bytes(0x421, {1}));
  for (int i = 0; i < 40; ++i) {
    robot.Say(*can::Encode(can::kBaseTwistCommand, can::BaseTwistCommand{0.3, 0}));
    Cycle(robot, 0x0F, 0.25);
  }
  robot.devices->Silence(0, robot.now);
  robot.devices->Silence(DeviceNumber("arm3"), robot.now);
  robot.Run(2);
  robot.heard.clear();
  for (int i = 0; i < 100; ++i) {
    robot.Say(*can::Encode(can::kBaseTwistCommand, can::BaseTwistCommand{0.3, 0}));
    Cycle(robot, 0x0F, 0.25);
  }
  EXPECT_FALSE(robot.Heard(0x211));
  EXPECT_FALSE(robot.Heard(0x183));
  EXPECT_TRUE(robot.Heard(0x184));
  EXPECT_EQ(robot.motion.base.v_mps, 0);
  EXPECT_EQ(robot.motion.joints_radps(2), 0);
  EXPECT_NEAR(robot.motion.joints_radps(3), 0.25, 1e-9);
}

TEST(DeviceSet, AnAbsentDeviceNeverSpeaksNorMoves) {
  DeviceSetConfig config = Robot::Config();
  config.absent[0] = config.absent[5] = true;
  Robot robot(config);
  robot.Run(1000);
  EXPECT_FALSE(robot.Heard(0x211));
  EXPECT_FALSE(robot.Heard(0x705));
  EXPECT_TRUE(robot.Heard(0x704));
}

TEST(DeviceSet, DevicesHaveNames) {
  EXPECT_EQ(DeviceNumber("tracer"), 0);
  EXPECT_EQ(DeviceNumber("arm1"), 1);
  EXPECT_EQ(DeviceNumber("arm7"), 7);
  for (const char* name : {"arm0", "arm8", "arm", "camera", ""}) {
    EXPECT_EQ(DeviceNumber(name), -1);
  }
}

can::Frame RandomFrame(Rng& rng) {
  constexpr std::uint32_t kLikely[] = {0x000, 0x080, 0x111, 0x121, 0x421, 0x441, 0x77F};
  can::Frame frame;
  const int kind = rng.Index(10);
  if (kind < 3) {
    frame.id = kLikely[rng.Index(7)];
  } else if (kind < 5) {
    frame.id = 0x201 + static_cast<std::uint32_t>(rng.Index(7));
  } else if (kind < 8) {
    frame.id = 0x601 + static_cast<std::uint32_t>(rng.Index(7));
  } else {
    frame.id = static_cast<std::uint32_t>(rng.Index(0x800));
  }
  frame.dlc = static_cast<std::uint8_t>(rng.Index(4) == 0 ? rng.Index(9) : 8);
  frame.extended = rng.Index(50) == 0;
  frame.remote = rng.Index(50) == 0;
  frame.error = rng.Index(50) == 0;
  for (std::size_t i = 0; i < frame.dlc; ++i) {
    frame.data[i] = static_cast<std::uint8_t>(rng.Index(3) == 0 ? rng.Index(4) : rng.Index(256));
  }
  if (frame.id > 0x600 && frame.id <= 0x607) {  // half of the requests at entries that exist
    constexpr std::uint16_t kIndex[] = {0x1400, 0x1600, 0x1800, 0x1A01, 0x6040, 0x6060, 0x60FF,
                                        0x607D, 0x6080, 0x60C5, 0x1016, 0x1017, 0x605A, 0x6007};
    const std::uint16_t index = kIndex[rng.Index(14)];
    frame.data[0] = static_cast<std::uint8_t>(0x23 | rng.Index(4) << 2);
    frame.data[1] = static_cast<std::uint8_t>(index & 0xFF);
    frame.data[2] = static_cast<std::uint8_t>(index >> 8);
    frame.data[3] = static_cast<std::uint8_t>(rng.Index(6));
  }
  return frame;
}

/// Devices fed straight, without a bus, so that malformed frames reach them too.
class RandomPort final : public Port {
 public:
  RandomPort(std::uint64_t seed, bool enabling) : rng_(seed), enabling_(enabling) {}
  Status Send(const can::Frame&) override { return Status::kOk; }
  bool Receive(can::Frame& frame) override {
    if (left_ == 0) {
      left_ = 8;
      return false;
    }
    --left_;
    frame = RandomFrame(rng_);
    const bool enables = frame.id == 0x421 || (frame.id >= 0x201 && frame.id <= 0x207) ||
                         frame.id == 0x000 || (frame.id >= 0x601 && frame.id <= 0x607);
    if (!enabling_ && enables) {  // anything but what enables
      frame.id = 0x111;
    }
    return true;
  }

 private:
  Rng rng_;
  bool enabling_;
  int left_ = 8;
};

// 8 frames a ms for 4 s, with fixed seeds.
TEST(DeviceSet, NoBytesBreakItsLimitsOrCrashIt) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RandomPort port(seed, /*enabling=*/true);
    DeviceSet devices(Robot::Config(), {&port});
    Joints joints = Joints::Zero();
    Time now{};
    for (int i = 0; i < 4000; ++i) {
      const DeviceMotion motion = devices.Step(now, joints);
      ASSERT_TRUE(motion.joints_radps.allFinite());
      ASSERT_LE(std::abs(motion.base.v_mps), 1.8);
      ASSERT_LE(std::abs(motion.base.omega_radps), 1.0);
      joints += motion.joints_radps * 1e-3;
      now += milliseconds(1);
    }
  }
}

TEST(DeviceSet, NothingMovesThatWasNotEnabled) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RandomPort port(seed, /*enabling=*/false);
    DeviceSet devices(Robot::Config(), {&port});
    Time now{};
    for (int i = 0; i < 2000; ++i) {
      const DeviceMotion motion = devices.Step(now, Joints::Zero());
      ASSERT_EQ(motion.base.v_mps, 0);
      ASSERT_EQ(motion.base.omega_radps, 0);
      ASSERT_EQ(motion.joints_radps, Joints::Zero());
      now += milliseconds(1);
    }
  }
}

// The drive may be told anything by its dictionary; without the enable sequence it must stand.
TEST(DeviceSet, AJointMovesOnlyInOperationEnabledOrWhileBraking) {
  for (std::uint64_t seed = 11; seed <= 16; ++seed) {
    RandomPort port(seed, /*enabling=*/true);
    DeviceSet devices(Robot::Config(), {&port});
    Time now{};
    Joints before = Joints::Zero();
    for (int i = 0; i < 4000; ++i) {
      const DeviceMotion motion = devices.Step(now, Joints::Zero());
      for (int k = 0; k < kArmNodes; ++k) {
        const bool enabled = devices.joint(k).drive_state() == DriveState::kOperationEnabled;
        if (!enabled) {
          ASSERT_LE(std::abs(motion.joints_radps(k)), std::abs(before(k)));
        }
      }
      before = motion.joints_radps;
      now += milliseconds(1);
    }
  }
}

}  // namespace
}  // namespace pipewright::hil
