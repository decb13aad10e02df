// SPDX-License-Identifier: MIT
// The three tasks together, as a virtual run calls them: what each hands to the others.
#include "ctrl/robot_program/robot_program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/ctrl/robot_program/device_bench.h"
#include "tests/ctrl/robot_program/small_world.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::DeviceBench;
using test::NoAllocScope;

struct Trial {
  explicit Trial(bool shared = false) : bench(shared) {
    RobotProgramConfig config;
    config.start_joints_rad = HomeJoints(TracerUf7());
    config.control.localization.odometry.track_m = TracerUf7().base.track_m;
    config.control.law.reached = 0.02;
    config.mapping.map = test::SmallMap();
    config.mission = DefaultMission();
    program = std::make_unique<RobotProgram>(config, TracerUf7());
  }

  /// One millisecond; what it cost of the heap inside a control cycle is a failure.
  void Tick() {
    if (camera_on && bench.now() >= camera.next_stamp()) {
      camera.Render(bench.plant().X_WS(), bench.Links(), *frame);
      last_map = program->Map(*frame);
    }
    if (plans_on && (bench.now().time_since_epoch() % milliseconds(50)).count() == 0) {
      program->Plan(bench.now());
    }
    if (bench.CycleDue()) {
      const NoAllocScope no_heap;
      program->Control(bench.base(), bench.arm(), bench.now());
    }
    bench.Tick();
  }
  void For(Duration time) {
    for (const Time end = bench.now() + time; bench.now() < end;) {
      Tick();
    }
  }
  const ControlReport& report() const { return program->control().report(); }
  const MissionOutput& mission() const { return program->planning().output(); }

  DeviceBench bench;
  std::unique_ptr<RobotProgram> program;
  hil::RobotBodies bodies = hil::RobotBodiesOf(hil::TracerUf7Description());
  hil::DepthCamera camera{{}, test::WallAndPipe(), bodies, 1};
  std::unique_ptr<DepthFrame> frame = std::make_unique<DepthFrame>();
  std::optional<Status> last_map;
  bool camera_on = true;
  bool plans_on = true;
};

TEST(RobotProgram, WorksThroughOnePortAsThroughTwo) {
  for (const bool shared : {false, true}) {
    SCOPED_TRACE(shared);
    Trial run(shared);
    run.camera_on = run.plans_on = false;
    run.For(seconds(3));
    EXPECT_EQ(run.report().phase, ControlPhase::kRunning);
    EXPECT_TRUE(run.report().state.valid);
    EXPECT_EQ(run.program->bus_counters().send_failures, 0U);
    EXPECT_EQ(run.program->bus_counters().backlogs, 0U);
    EXPECT_LT(run.bench.bus(0).PeakLoad(), 0.9);
    EXPECT_EQ(run.bench.base().counters().rx_dropped, 0U);
    EXPECT_EQ(run.bench.arm().counters().rx_dropped, 0U);
    EXPECT_EQ(run.bench.joints.size() % kArmJoints, 0U);
    // Neither driver took a frame twice, or one of the other's for a broken one of its own.
    EXPECT_EQ(run.report().base_fault.problem, Problem::kNone);
    EXPECT_EQ(run.report().arm_fault.problem, Problem::kNone);
  }
}

TEST(RobotProgram, MapsOnlyOnceItKnowsWhereItIs) {
  Trial run;
  run.plans_on = false;
  run.For(milliseconds(50));  // one frame, long before the devices are up
  ASSERT_TRUE(run.last_map);
  EXPECT_EQ(*run.last_map, Status::kStale);
  EXPECT_EQ(run.program->mapping().map().counts().free, 0);
  run.For(seconds(3));
  EXPECT_EQ(*run.last_map, Status::kOk);
  EXPECT_GT(run.program->mapping().map().counts().free, 1000);
  EXPECT_GT(run.program->mapping().counters().without_pose, 0U);
  EXPECT_EQ(run.program->mapping().counters().refused, 0U);
}

TEST(RobotProgram, HandsTheMapToTheLawAndTheGoalToTheControlTask) {
  Trial run;
  run.plans_on = false;
  run.camera_on = false;
  run.For(milliseconds(2500));
  ASSERT_EQ(run.report().phase, ControlPhase::kRunning);
  // No plane is known, and the planner has no map: no goal.
  EXPECT_FALSE(std::isfinite(run.report().stats.clearance.plane_m));
  EXPECT_EQ(run.report().progress.id, 0U);

  run.camera_on = true;
  run.For(seconds(1));
  // The floor has been found from the frames; the law keeps its distance to it.
  EXPECT_TRUE(std::isfinite(run.report().stats.clearance.plane_m));

  run.plans_on = true;
  run.For(seconds(2));
  EXPECT_NE(run.mission().state, MissionState::kStart);
  const std::uint32_t id = run.program->planning().goal().id;
  ASSERT_NE(id, 0U);
  EXPECT_EQ(run.report().progress.id, id);
  EXPECT_FALSE(run.bench.AtRest());
}

TEST(RobotProgram, TakesACameraThatFallsSilentForADeviceFaultAndStops) {
  Trial run;
  run.For(seconds(3));
  ASSERT_EQ(run.report().phase, ControlPhase::kRunning);
  ASSERT_FALSE(run.program->camera_lost());
  run.camera_on = false;
  run.For(milliseconds(900));
  EXPECT_FALSE(run.program->camera_lost());
  EXPECT_EQ(run.mission().stop, StopReason::kNone);
  run.For(milliseconds(250));  // the timeout of 1 s, and up to two plans' time
  EXPECT_TRUE(run.program->camera_lost());
  EXPECT_EQ(run.mission().state, MissionState::kFault);
  EXPECT_EQ(run.mission().stop, StopReason::kDeviceFault);
  run.For(seconds(3));
  EXPECT_EQ(run.report().phase, ControlPhase::kStopped);
  EXPECT_TRUE(run.bench.AtRest());
}

TEST(RobotProgram, DoesNotBlameTheCameraBeforeTheRobotKnowsWhereItIs) {
  Trial run;
  run.camera_on = false;
  run.bench.devices().Silence(4, Time{});  // the arm never comes up
  run.For(milliseconds(3000));
  EXPECT_FALSE(run.program->camera_lost());
  run.For(seconds(8));
  EXPECT_EQ(run.mission().stop, StopReason::kDeviceFault);
  EXPECT_FALSE(run.program->camera_lost());
  EXPECT_EQ(run.report().arm_fault.node, 4);
}

TEST(RobotProgram, StopsFromAnywhereWhenAsked) {
  Trial run;
  run.For(seconds(4));
  run.program->RequestStop();
  run.For(seconds(3));
  EXPECT_EQ(run.report().phase, ControlPhase::kStopped);
  EXPECT_TRUE(run.bench.AtRest());
}

}  // namespace
}  // namespace pipewright
