// SPDX-License-Identifier: MIT
#include "hil/emulator/emulator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "platform/can/cia402.h"
#include "platform/can/loopback_bus.h"
#include "platform/can/tracer.h"
#include "platform/drivers/arm_driver.h"
#include "platform/drivers/tracer_driver.h"

namespace pipewright::hil {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Joints = Vec<kPlantJoints>;

constexpr const char* kCell = R"(
name = "cell"
[workspace]
min_m = [0.6, -0.4, 0.2]
max_m = [1.4, 0.4, 0.9]
[start]
x_m = 0.0
y_m = 0.1
yaw_rad = 0.5
joints_rad = [0.1, -0.9, 0.0, 0.5, 0.0, -0.4, 0.2]
[map]
lo_m = [-1.0, -1.0, -0.1]
hi_m = [1.9, 1.0, 1.4]
[[plane]]
name = "floor"
normal = [0, 0, 1]
offset_m = 0.0
ground = true
[[box]]
name = "crate"
center_m = [3.0, 0.0, 0.3]
size_m = [0.4, 0.4, 0.6]
[[cylinder]]
name = "post"
from_m = [1.2, 0.0, 0.0]
to_m = [1.2, 0.0, 1.2]
radius_m = 0.06
)";

Scenario Cell(const std::string& more = "") {
  const ScenarioResult result = ParseScenario(kCell + more, "cell", "");
  EXPECT_TRUE(result.scenario) << (result.errors.empty() ? "" : result.errors[0]);
  return result.scenario.value_or(Scenario{});
}

/// The emulator, and drivers that do as the test says.
struct Bench {
  explicit Bench(const Scenario& scenario) {
    emulator = std::make_unique<Emulator>(scenario, Joints::Zero(), 1,
                                          std::vector<Port*>{&base_port, &arm_port});
  }
  void For(Duration time) {
    for (const Time end = now + time; now < end; now += Emulator::kTick) {
      base_bus.AdvanceTo(now);
      arm_bus.AdvanceTo(now);
      if ((now.time_since_epoch() % milliseconds(10)).count() == 0) {
        Control();
      }
      emulator->Step(now);
    }
  }
  void Control() {
    can::Frame frame;
    while (base_host.Receive(frame)) {
      base.OnFrame(frame);
    }
    while (arm_host.Receive(frame)) {
      arm.OnFrame(frame);
    }
    static_cast<void>(base.Command(v_mps, omega_radps));
    static_cast<void>(arm.Command(qdot_radps));
    TxBatch out;
    base.Step(now, out);
    for (const can::Frame& f : out) {
      EXPECT_EQ(base_host.Send(f), Status::kOk);
    }
    out.clear();
    arm.Step(now, out);
    for (const can::Frame& f : out) {
      EXPECT_EQ(arm_host.Send(f), Status::kOk);
    }
  }
  const BasePose& pose() const { return emulator->plant().base(); }

  can::LoopbackBus base_bus{can::kTracerBitrate};
  can::LoopbackBus arm_bus{can::kArmBitrate};
  can::LoopbackBus::Port& base_host = *base_bus.Attach();
  can::LoopbackBus::Port& arm_host = *arm_bus.Attach();
  PortOf<can::LoopbackBus::Port> base_port{*base_bus.Attach()};
  PortOf<can::LoopbackBus::Port> arm_port{*arm_bus.Attach()};
  TracerDriver base;
  ArmDriver arm;
  std::unique_ptr<Emulator> emulator;
  Time now{};
  double v_mps = 0;
  double omega_radps = 0;
  Joints qdot_radps = Joints::Zero();
};

/// Ground truth is cached by scenario; the tests keep theirs to themselves.
class EmulatorTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    ASSERT_EQ(setenv("XDG_CACHE_HOME", (testing::TempDir() + "emulator_cache").c_str(), 1), 0);
  }
};

TEST_F(EmulatorTest, StartsWhereTheScenarioSays) {
  const Bench bench(Cell());
  EXPECT_EQ(bench.pose().x_m, 0);
  EXPECT_EQ(bench.pose().y_m, 0.1);
  EXPECT_EQ(bench.pose().yaw_rad, 0.5);
  EXPECT_EQ(bench.emulator->plant().joints_rad()(1), -0.9);
  Scenario at_home = Cell();
  at_home.start.joints_rad.clear();
  can::LoopbackBus bus(500'000);
  PortOf<can::LoopbackBus::Port> port(*bus.Attach());
  const Joints home = Joints::LinSpaced(0.1, 0.7);
  const Emulator emulator(at_home, home, 1, {&port});
  EXPECT_EQ(emulator.plant().joints_rad(), home);
  EXPECT_EQ(emulator.start_joints_rad(), home);
}

TEST_F(EmulatorTest, NeverSlidesSidewaysAndCountsTheWay) {
  Bench bench(Cell());
  bench.For(seconds(3));
  ASSERT_TRUE(bench.base.ready() && bench.arm.ready());
  EXPECT_EQ(bench.emulator->base_travel_m(), 0);
  EXPECT_EQ(bench.emulator->joint_travel_rad(), 0);

  bench.v_mps = 0.2;  // straight: the way is the distance
  bench.For(seconds(2));
  bench.v_mps = 0;
  bench.For(seconds(1));
  const double straight_m = std::hypot(bench.pose().x_m, bench.pose().y_m - 0.1);
  EXPECT_NEAR(straight_m, 0.4, 0.02);
  EXPECT_NEAR(bench.emulator->base_travel_m(), straight_m, 1e-9);
  EXPECT_NEAR(bench.pose().y_m - 0.1, straight_m * std::sin(0.5), 1e-9);

  bench.omega_radps = 0.5;  // on the spot: no way
  bench.For(seconds(1));
  bench.omega_radps = 0;
  bench.For(seconds(1));
  EXPECT_NEAR(bench.emulator->base_travel_m(), straight_m, 1e-9);

  // An arc back and forth: the way is v / omega times the angle turned, both ways.
  const double before_rad = bench.pose().yaw_rad;
  bench.v_mps = 0.1;
  bench.omega_radps = 0.4;
  bench.For(seconds(2));
  bench.v_mps = bench.omega_radps = 0;
  bench.For(seconds(1));
  const double turned_rad = bench.pose().yaw_rad - before_rad;
  EXPECT_GT(turned_rad, 0.5);
  EXPECT_NEAR(bench.emulator->base_travel_m() - straight_m, turned_rad * 0.1 / 0.4, 0.02);

  EXPECT_GT(bench.emulator->lateral_speed_max_mps(), 0);  // it was looked for
  EXPECT_LT(bench.emulator->lateral_speed_max_mps(), 1e-9);
}

TEST_F(EmulatorTest, CountsTheTurnsOfAllJointsBackAndForth) {
  Bench bench(Cell());
  bench.For(seconds(3));
  ASSERT_TRUE(bench.arm.ready());
  bench.qdot_radps << 0.2, 0.1, 0, 0, -0.3, 0, 0;
  const Joints start = bench.emulator->plant().joints_rad();
  bench.For(seconds(1));
  bench.qdot_radps.setZero();
  bench.For(milliseconds(500));
  const Joints there = bench.emulator->plant().joints_rad();
  bench.qdot_radps << -0.2, -0.1, 0, 0, 0.3, 0, 0;
  bench.For(seconds(1));
  bench.qdot_radps.setZero();
  bench.For(milliseconds(500));
  const Joints back = bench.emulator->plant().joints_rad();
  EXPECT_NEAR((there - start)(4), -0.3, 0.02);
  EXPECT_NEAR(bench.emulator->joint_travel_rad(),
              (there - start).cwiseAbs().sum() + (back - there).cwiseAbs().sum(), 1e-9);
}

TEST_F(EmulatorTest, MeasuresAndCoversWhereTheRobotIs) {
  Bench bench(Cell());
  bench.emulator->Measure(bench.now);
  EXPECT_EQ(bench.emulator->truth().contacts(), 0);
  EXPECT_GT(bench.emulator->truth().min_pipe_m(), 0.1);
  EXPECT_TRUE(std::isfinite(bench.emulator->truth().min_self_m()));
  // Onto the post: it is touched, and the truth says what by name.
  bench.For(seconds(3));
  bench.omega_radps = -0.5;
  bench.For(seconds(1));
  bench.omega_radps = 0;
  bench.v_mps = 0.4;
  for (int i = 0; i < 300; ++i) {
    bench.For(milliseconds(10));
    bench.emulator->Measure(bench.now);
  }
  EXPECT_GT(bench.emulator->truth().contacts(), 0);
  ASSERT_FALSE(bench.emulator->truth().touched().empty());
  EXPECT_NE(bench.emulator->truth().touched()[0].find("post"), std::string::npos);
  EXPECT_GT(bench.emulator->truth().coverage().covered, 0);
}

/// Frames that the camera gives in `ms` milliseconds of nothing else.
int Frames(Emulator& emulator, int ms) {
  const auto frame = std::make_unique<DepthFrame>();
  int frames = 0;
  for (int i = 0; i < ms; ++i) {
    const Time now{milliseconds(i)};
    if (emulator.FrameDue(now)) {
      emulator.Render(*frame);
      EXPECT_LE(frame->stamp, now);
      EXPECT_LT(now - frame->stamp, milliseconds(1));
      ++frames;
    }
  }
  return frames;
}

TEST_F(EmulatorTest, GivesFramesAtTheCamerasRateUntilItFallsSilent) {
  const std::string fault = "[[fault]]\ndevice = \"camera\"\nkind = ";
  Bench sound(Cell());
  EXPECT_EQ(Frames(*sound.emulator, 1000), 15);
  Bench silent(Cell(fault + "\"silent\"\nat_s = 0.5\n"));
  EXPECT_EQ(Frames(*silent.emulator, 1000), 8);  // at 0, 1/15 ... 7/15 s
  Bench absent(Cell(fault + "\"absent\"\n"));
  EXPECT_EQ(Frames(*absent.emulator, 1000), 0);
  // As a scenario's fault and one laid over it.
  Bench twice(Cell(fault + "\"silent\"\nat_s = 0.5\n" + fault + "\"silent\"\nat_s = 0.8\n"));
  EXPECT_EQ(Frames(*twice.emulator, 1000), 8);
}

TEST_F(EmulatorTest, LetsTheWheelsSlipWhenTheScenarioSaysAndTellsNobody) {
  Bench sound(Cell());
  Bench slipping(
      Cell("[base]\nyaw_scale_slow = 1.06\n[[fault]]\ndevice = \"tracer\"\n"
           "kind = \"slip\"\nat_s = 4\nfor_s = 1\nleft = 0.5\nright = 0.5\n"));
  for (Bench* bench : {&sound, &slipping}) {
    bench->For(seconds(3));
    bench->v_mps = 0.1;
    bench->For(seconds(3));
    bench->v_mps = 0;
    bench->For(seconds(1));
    bench->omega_radps = 0.2;
    bench->For(seconds(2));
    bench->omega_radps = 0;
    bench->For(seconds(1));
  }
  // A second at 0.1 m/s of which half is lost; turns that are 1.06 times as far.
  EXPECT_NEAR(slipping.emulator->base_travel_m(), sound.emulator->base_travel_m() - 0.05, 1e-3);
  EXPECT_NEAR(slipping.pose().yaw_rad - 0.5, 1.06 * (sound.pose().yaw_rad - 0.5), 1e-9);
  EXPECT_EQ(slipping.base.odometer().left_m, sound.base.odometer().left_m);
  EXPECT_EQ(slipping.base.odometer().right_m, sound.base.odometer().right_m);
}

TEST_F(EmulatorTest, LeavesAbsentDevicesOutAndSilencesThoseThatAreToFallSilent) {
  const std::string device = "[[fault]]\ndevice = ";
  Bench no_elbow(Cell(device + "\"arm3\"\nkind = \"absent\"\n"));
  no_elbow.For(seconds(6));
  EXPECT_TRUE(no_elbow.base.ready());
  EXPECT_EQ(no_elbow.arm.fault().problem, Problem::kNotHeard);
  EXPECT_EQ(no_elbow.arm.fault().node, 3);

  Bench no_base(Cell(device + "\"tracer\"\nkind = \"absent\"\n"));
  no_base.For(seconds(6));
  EXPECT_TRUE(no_base.arm.ready());
  EXPECT_EQ(no_base.base.fault().problem, Problem::kNotHeard);

  Bench quiet(Cell(device + "\"arm5\"\nkind = \"silent\"\nat_s = 3.5\n" + device +
                   "\"arm5\"\nkind = \"silent\"\nat_s = 9\n"));
  quiet.qdot_radps.setConstant(0.1);
  quiet.For(milliseconds(3500));
  EXPECT_TRUE(quiet.arm.ready());
  EXPECT_GT(quiet.emulator->joint_travel_rad(), 0.1);
  quiet.For(seconds(1));
  EXPECT_EQ(quiet.arm.phase(), DriverPhase::kFault);
  EXPECT_EQ(quiet.arm.fault().node, 5);
  EXPECT_TRUE(quiet.base.ready());
  const double rest_rad = quiet.emulator->joint_travel_rad();
  quiet.For(seconds(1));
  EXPECT_EQ(quiet.emulator->joint_travel_rad(), rest_rad);  // by its own watchdog, too
}

TEST_F(EmulatorTest, IsAFunctionOfTheScenarioAndTheSeed) {
  const auto depths = [](std::uint64_t seed) {
    can::LoopbackBus bus(500'000);
    PortOf<can::LoopbackBus::Port> port(*bus.Attach());
    Emulator emulator(Cell(), Joints::Zero(), seed, {&port});
    const auto frame = std::make_unique<DepthFrame>();
    emulator.Render(*frame);
    return std::vector<std::uint16_t>(frame->depth_mm.begin(), frame->depth_mm.end());
  };
  EXPECT_EQ(depths(1), depths(1));
  EXPECT_NE(depths(1), depths(2));
}

TEST_F(EmulatorTest, ACameraOnItsOwnThreadSeesTheSameAndPassesOverWhatItWasTooLateFor) {
  can::LoopbackBus bus(500'000);
  PortOf<can::LoopbackBus::Port> port(*bus.Attach());
  Emulator at_once(Cell(), Joints::Zero(), 1, {&port});
  Emulator apart(Cell(), Joints::Zero(), 1, {&port});
  const auto wanted = std::make_unique<DepthFrame>();
  const auto frame = std::make_unique<DepthFrame>();
  Emulator::View view;

  at_once.Render(*wanted);
  apart.Look(Time{milliseconds(3)}, view);
  ASSERT_TRUE(apart.FrameDue(view));
  EXPECT_EQ(apart.Render(view, *frame), 0);
  EXPECT_EQ(frame->depth_mm, wanted->depth_mm);
  EXPECT_EQ(frame->stamp, Time{milliseconds(3)}) << "when it was seen, not when it was due";
  EXPECT_FALSE(apart.FrameDue(view));

  // Those of 1/15, 2/15 and 3/15 s never come; the one of 4/15 s does.
  apart.Look(Time{milliseconds(270)}, view);
  EXPECT_EQ(apart.Render(view, *frame), 3);
  for (int i = 1; i <= 4; ++i) {
    at_once.Render(*wanted);
  }
  EXPECT_EQ(frame->sequence, wanted->sequence);
  EXPECT_EQ(frame->depth_mm, wanted->depth_mm);
  EXPECT_FALSE(apart.FrameDue(view));
}

TEST_F(EmulatorTest, TheBaseIsBuiltAsAsked) {
  can::LoopbackBus bus(500'000);
  PortOf<can::LoopbackBus::Port> port(*bus.Attach());
  PortOf<can::LoopbackBus::Port> host(*bus.Attach());
  TracerConfig tracer;
  tracer.modes = can::kModesTracer12;
  Emulator emulator(Cell(), Joints::Zero(), 1, {&port}, tracer);
  emulator.devices().tracer().SetRemote(true, 0, 0);
  for (int i = 1; i <= 300; ++i) {
    emulator.Step(Time{milliseconds(i)});
    bus.AdvanceTo(Time{milliseconds(i)});
  }
  can::Frame frame;
  int states = 0;
  while (host.Receive(frame)) {
    if (frame.id == 0x211) {
      EXPECT_EQ(frame.data[1], 0) << "remote control, by the manual of v1.2; 3 by the SDK";
      ++states;
    }
  }
  EXPECT_GT(states, 3);
}

}  // namespace
}  // namespace pipewright::hil
