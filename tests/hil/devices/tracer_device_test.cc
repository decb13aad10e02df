// SPDX-License-Identifier: MIT
#include "hil/devices/tracer_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "node_bench.h"
#include "platform/can/tracer.h"

namespace pipewright::hil {
namespace {

using std::chrono::milliseconds;

/// The base on a desk, ticked each ms; what it says is kept.
struct Bench {
  explicit Bench(const TracerConfig& config = {}) : base(config) {}

  void Run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now += milliseconds(1);
      base.Step(now, said);
      travelled_m += base.motion().v_mps * 1e-3;
      turned_rad += base.motion().omega_radps * 1e-3;
    }
  }
  void Hear(const can::Frame& frame) { base.OnFrame(frame, now); }
  void Drive(const can::Frame& command, int ms) {
    for (int i = 0; i < ms; i += 20) {
      Hear(command);
      Run(20);
    }
  }
  can::Frame Last(std::uint32_t id) const {
    for (auto frame = said.rbegin(); frame != said.rend(); ++frame) {
      if (frame->id == id) {
        return *frame;
      }
    }
    return {};
  }
  int Count(std::uint32_t id) const {
    return static_cast<int>(
        std::count_if(said.begin(), said.end(), [id](const can::Frame& f) { return f.id == id; }));
  }
  void Enable() {
    Run(110);
    Hear(Bytes(0x421, {1}));
  }

  TracerDevice base;
  Time now{};
  std::vector<can::Frame> said;
  double travelled_m = 0;
  double turned_rad = 0;
};

// What the vendor's SDK client really sends.
const can::Frame kSdkMode = Bytes(0x421, {1, 0, 0, 0, 0, 0, 0, 0});
const can::Frame kSdkForward = Bytes(0x111, {0x01, 0xF4, 0, 0, 0, 0, 0, 0});
const can::Frame kSdkCurve = Bytes(0x111, {0x01, 0xF4, 0xFE, 0xD4, 0, 0, 0, 0});
const can::Frame kSdkLight = Bytes(0x121, {0x01, 0x03, 0x28, 0, 0, 0, 0, 0});

TEST(TracerDevice, SaysEachFrameAtItsPeriod) {
  Bench bench;
  bench.Run(101 + 1000 - 1);
  struct Case {
    std::uint32_t id;
    int in_a_second;
  };
  for (const Case& c :
       {Case{0x211, 50}, Case{0x221, 50}, Case{0x231, 50}, Case{0x241, 50}, Case{0x251, 50},
        Case{0x252, 50}, Case{0x311, 50}, Case{0x261, 10}, Case{0x262, 10}, Case{0x361, 2}}) {
    SCOPED_TRACE(testing::Message() << std::hex << c.id);
    EXPECT_EQ(bench.Count(c.id), c.in_a_second);
    EXPECT_EQ(bench.Last(c.id).dlc, 8);
  }
  EXPECT_EQ(bench.Last(0x211).data[7], 49) << "rolling count";
}

// 211#0100010000800000: a real Mini Bunker with its e-stop engaged.
// 211#00000103000000B1: a real Hunter SE, 177 frames after its count began.
TEST(TracerDevice, ItsStateFrameIsThatOfRealBases) {
  Bench bunker(TracerConfig{.estop_error = 0x0080, .battery_V = 25.6});
  bunker.base.PressEmergencyStop(true);
  bunker.Run(101);
  EXPECT_EQ(bunker.Last(0x211), Bytes(0x211, {1, 0, 1, 0, 0, 0x80, 0, 0}));
  Bench hunter(TracerConfig{.battery_V = 25.9});
  hunter.Run(101 + 20 * 0xB1);
  EXPECT_EQ(hunter.Last(0x211), Bytes(0x211, {0, 0, 1, 3, 0, 0, 0, 0xB1}));
}

TEST(TracerDevice, ObeysTheVendorsClient) {
  Bench bench;
  bench.Run(200);
  bench.Hear(kSdkMode);
  bench.Drive(kSdkForward, 600);
  EXPECT_EQ(bench.Last(0x211).data[1], 1);
  EXPECT_EQ(bench.Last(0x221), Bytes(0x221, {0x01, 0xF4, 0, 0, 0, 0, 0, 0}));
  bench.Drive(kSdkCurve, 600);
  EXPECT_EQ(bench.Last(0x221), Bytes(0x221, {0x01, 0xF4, 0xFE, 0xD4, 0, 0, 0, 0}));
  bench.Hear(kSdkLight);
  bench.Run(20);
  const can::Frame light = bench.Last(0x231);
  EXPECT_EQ(light.data[0], 1);
  EXPECT_EQ(light.data[1], 3);
  EXPECT_EQ(light.data[2], 0x28);
  EXPECT_EQ(bench.base.rejected(), 0);
}

TEST(TracerDevice, StandsUntilItIsInCanMode) {
  for (const can::Frame& mode : {Bytes(0x421, {1}), kSdkMode}) {
    Bench bench;
    bench.Run(150);
    bench.Drive(kSdkForward, 200);
    EXPECT_EQ(bench.base.motion().v_mps, 0);
    bench.Hear(mode);
    bench.Drive(kSdkForward, 200);
    EXPECT_GT(bench.base.motion().v_mps, 0.2);
    bench.Hear(Bytes(0x421, {0}));
    bench.Drive(kSdkForward, 600);
    EXPECT_EQ(bench.base.motion().v_mps, 0);
  }
}

TEST(TracerDevice, AfterHalfASecondWithoutCommandItBrakes) {
  Bench bench(TracerConfig{.accel_mps2 = 5, .brake_mps2 = 1.0});
  bench.Enable();
  bench.Drive(kSdkForward, 400);
  bench.Run(480);  // the last command is 20 ms old already
  EXPECT_EQ(bench.base.motion().v_mps, 0.5);
  EXPECT_EQ(bench.base.watchdog_trips(), 0);
  bench.Run(100);
  EXPECT_EQ(bench.base.watchdog_trips(), 1);
  EXPECT_NEAR(bench.base.motion().v_mps, 0.4, 1e-9);
  bench.Run(400);
  EXPECT_NEAR(bench.base.motion().v_mps, 0, 1e-9);
  bench.Drive(kSdkForward, 400);
  EXPECT_EQ(bench.base.motion().v_mps, 0.5) << "it goes on when commands come again";
  EXPECT_EQ(bench.base.watchdog_trips(), 1);
}

TEST(TracerDevice, AcceleratesNoFasterThanItCanAndClampsToTheManual) {
  Bench bench(TracerConfig{.accel_mps2 = 2.0, .alpha_radps2 = 4.0});
  bench.Enable();
  bench.Drive(Bytes(0x111, {0x7F, 0xFF, 0x80, 0x00, 0, 0, 0, 0}), 100);
  EXPECT_NEAR(bench.base.motion().v_mps, 0.2, 1e-9);
  EXPECT_NEAR(bench.base.motion().omega_radps, -0.4, 1e-9);
  bench.Drive(Bytes(0x111, {0x7F, 0xFF, 0x80, 0x00, 0, 0, 0, 0}), 1000);
  EXPECT_EQ(bench.base.motion().v_mps, 1.8);
  EXPECT_EQ(bench.base.motion().omega_radps, -1.0);
}

TEST(TracerDevice, TheEmergencyStopBrakesAndModeCommandsAreStillTaken) {
  Bench bench(TracerConfig{.stop_mps2 = 5.0});
  bench.Enable();
  bench.Drive(kSdkForward, 600);
  bench.base.PressEmergencyStop(true);
  bench.Drive(kSdkForward, 120);
  EXPECT_EQ(bench.base.motion().v_mps, 0);
  EXPECT_EQ(bench.Last(0x211).data[0], 1);
  EXPECT_EQ(bench.Last(0x211).data[4], 0x80);
  bench.Hear(Bytes(0x421, {0}));
  bench.Run(20);
  EXPECT_EQ(bench.Last(0x211).data[1], 0);
  bench.Hear(kSdkMode);
  bench.Run(20);
  EXPECT_EQ(bench.Last(0x211).data[1], 1);
  bench.base.PressEmergencyStop(false);
  bench.Drive(kSdkForward, 600);
  EXPECT_GT(bench.base.motion().v_mps, 0.4);
}

TEST(TracerDevice, TheRemoteControlHasTheLastWord) {
  Bench bench;
  bench.Enable();
  bench.Drive(kSdkForward, 400);
  bench.base.SetRemote(true, -0.2, 0.1);
  bench.Drive(kSdkForward, 800);
  EXPECT_EQ(bench.Last(0x211).data[1], 3);
  EXPECT_NEAR(bench.base.motion().v_mps, -0.2, 1e-12);
  bench.Hear(kSdkMode);
  bench.Hear(kSdkLight);
  bench.Run(20);
  EXPECT_EQ(bench.Last(0x211).data[1], 3);
  EXPECT_EQ(bench.Last(0x231).data[1], 3) << "lights still work";
  bench.base.SetRemote(false, 0, 0);
  bench.Drive(kSdkForward, 800);
  EXPECT_EQ(bench.Last(0x211).data[1], 0);
  EXPECT_EQ(bench.base.motion().v_mps, 0);
}

TEST(TracerDevice, ALostMotorDriverLatchesUntilResetWithItsCauseGone) {
  for (const can::Frame& reset : {Bytes(0x441, {0}), Bytes(0x441, {0, 0, 0, 0, 0, 0, 0, 0})}) {
    Bench bench;
    bench.Enable();
    bench.Drive(kSdkForward, 400);
    bench.base.LoseMotorDriver(2, true);
    bench.Drive(kSdkForward, 400);
    EXPECT_EQ(bench.base.motion().v_mps, 0);
    EXPECT_EQ(bench.Last(0x211).data[0], 2);
    EXPECT_EQ(bench.Last(0x211).data[4], 0x40);
    bench.Run(100);
    EXPECT_EQ(bench.Last(0x262).data[5], 0x10);
    bench.Hear(reset);
    EXPECT_TRUE(bench.base.exception());
    bench.base.LoseMotorDriver(2, false);
    EXPECT_TRUE(bench.base.exception());
    bench.Hear(reset);
    EXPECT_FALSE(bench.base.exception());
  }
}

TEST(TracerDevice, AFlatBatteryTakesTheDrivesPower) {
  Bench bench;
  bench.Enable();
  bench.base.SetBattery(22.3, 10);
  bench.Drive(kSdkForward, 400);
  EXPECT_EQ(bench.Last(0x211).data[4], 0x02);
  EXPECT_EQ(bench.base.motion().v_mps, 0.5);
  bench.base.SetBattery(21.9, 3);
  bench.Drive(kSdkForward, 600);
  EXPECT_EQ(bench.Last(0x211).data[4], 0x03);
  EXPECT_EQ(bench.base.motion().v_mps, 0);
  EXPECT_EQ(bench.Last(0x361).data[0], 3);
}

TEST(TracerDevice, WheelsOdometerAndMotorsAgreeWithTheMotion) {
  TracerConfig config;
  Bench bench(config);
  bench.Enable();
  bench.Drive(kSdkCurve, 2000);
  const Result<can::BaseOdometer> odometer = can::Decode(can::kBaseOdometer, bench.Last(0x311));
  ASSERT_TRUE(odometer.ok());
  const double centre_m = (odometer->left_m + odometer->right_m) / 2;
  const double turn_rad = (odometer->right_m - odometer->left_m) / config.track_m;
  // The last frame may be 20 ms old, and is in mm.
  EXPECT_NEAR(centre_m, bench.travelled_m, 0.5 * 0.02 + 0.001);
  EXPECT_NEAR(turn_rad, bench.turned_rad, 0.3 * 0.02 + 0.001 / config.track_m);
  const auto left = can::Decode(can::kBaseMotorFast, bench.Last(0x251));
  const auto right = can::Decode(can::kBaseMotorFast, bench.Last(0x252));
  const double rpm_per_mps = 60 / (2 * M_PI * 0.0605);
  EXPECT_NEAR(left->speed_rpm, (0.5 + 0.3 * 0.175) * rpm_per_mps, 0.5);
  EXPECT_NEAR(right->speed_rpm, (0.5 - 0.3 * 0.175) * rpm_per_mps, 0.5);
}

TEST(TracerDevice, SlipAndYawScaleAreWhatItsOwnFramesDoNotSay) {
  Bench bench(TracerConfig{.slip = {.yaw_scale_slow = 1.05, .slip = 0.1}});
  bench.Enable();
  bench.Drive(kSdkCurve, 1000);
  EXPECT_NEAR(bench.base.motion().v_mps, 0.9 * 0.5, 1e-12);
  EXPECT_NEAR(bench.base.motion().omega_radps, -0.9 * 1.05 * 0.3, 1e-12);
  EXPECT_EQ(bench.Last(0x221), Bytes(0x221, {0x01, 0xF4, 0xFE, 0xD4, 0, 0, 0, 0}));
}

TEST(TracerDevice, ModeCodesFollowTheConfiguredManual) {
  Bench bench(TracerConfig{.modes = can::kModesTracer20});
  bench.Enable();
  bench.Run(20);
  EXPECT_EQ(bench.Last(0x211).data[1], 1);
  bench.base.SetRemote(true, 0, 0);
  bench.Run(20);
  EXPECT_EQ(bench.Last(0x211).data[1], 2);
}

TEST(TracerDevice, TellsItsVersionToTheVendorsClient) {
  // ugv_sdk's RequestVersion (agilex_base.hpp) waits for 80 bytes, and takes none but what prints.
  for (const can::Frame& request : {Bytes(0x4A1, {1}), Bytes(0x411, {1, 0, 0, 0, 0, 0, 0, 0})}) {
    Bench bench;
    bench.Run(200);
    EXPECT_EQ(bench.Count(0x4A1), 0);
    bench.Hear(request);
    bench.Run(50);
    EXPECT_EQ(bench.Count(0x4A1), 10);
    std::string text;
    for (const can::Frame& frame : bench.said) {
      if (frame.id == 0x4A1) {
        text.append(reinterpret_cast<const char*>(frame.data.data()), frame.dlc);
      }
    }
    EXPECT_EQ(text.size(), 80);
    EXPECT_TRUE(std::all_of(text.begin(), text.end(), [](char c) { return c >= 32 && c <= 126; }));
    EXPECT_NE(text.find("V2"), std::string::npos);
    EXPECT_EQ(bench.base.rejected(), 0);
    bench.Hear(request);
    bench.Run(50);
    EXPECT_EQ(bench.Count(0x4A1), 20);
  }
}

TEST(TracerDevice, MalformedFramesForItAreCounted) {
  Bench bench;
  bench.Enable();
  can::Frame remote = kSdkForward;
  remote.remote = true;
  for (const can::Frame& bad : {Bytes(0x111, {1, 2}), Bytes(0x421, {7}), Bytes(0x421, {1, 0}),
                                Bytes(0x121, {9, 0, 0, 0, 0, 0, 0, 0}), Bytes(0x441, {3}),
                                Bytes(0x411, {}), Bytes(0x4A1, {2}), remote}) {
    bench.Hear(bad);
  }
  bench.Run(20);
  EXPECT_EQ(bench.base.rejected(), 8);
  EXPECT_EQ(bench.Count(0x4A1), 0);
  EXPECT_EQ(bench.base.motion().v_mps, 0);
}

}  // namespace
}  // namespace pipewright::hil
