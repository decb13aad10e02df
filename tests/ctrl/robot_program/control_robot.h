// SPDX-License-Identifier: MIT
// The control task on the device bench, in an empty hall.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>

#include "ctrl/robot_program/control_task.h"
#include "perception/map/distance_field.h"
#include "tests/ctrl/robot_program/device_bench.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright::test {

/// A hall of 3 m in which nothing is in the way.
inline DistanceField EmptyHall() {
  MapConfig config;
  config.lo = config.workspace_lo = {-30, -30, -2};
  config.hi = config.workspace_hi = {29, 29, 39};
  config.brick_capacity = 1;
  VoxelGrid grid(config);
  grid.MarkSweptSphere(Vector3d::Zero(), 5);
  DistanceField field(config);
  field.Update(grid);
  return field;
}

struct Robot {
  explicit Robot(const ControlTaskConfig& config = Config())
      : task(std::make_unique<ControlTask>(config, TracerUf7())) {}

  static ControlTaskConfig Config() {
    ControlTaskConfig config;
    config.law.reached = 0.01;
    config.localization.odometry.track_m = TracerUf7().base.track_m;
    config.scans_correct = true;
    return config;
  }

  const ControlReport& report() const { return task->report(); }

  void Cycle() {
    TxBatch base_out;
    TxBatch arm_out;
    {
      const NoAllocScope no_heap;
      can::Frame frame;
      while (!deaf && bench.base().Receive(frame)) {
        task->OnBaseFrame(frame);
      }
      while (!deaf && bench.arm().Receive(frame)) {
        task->OnArmFrame(frame);
      }
      task->Step(bench.now(), scene, field, goal, base_out, arm_out);
    }
    for (const can::Frame& frame : base_out) {
      EXPECT_EQ(bench.base().Send(frame), Status::kOk);
    }
    for (const can::Frame& frame : arm_out) {
      EXPECT_EQ(bench.arm().Send(frame), Status::kOk);
    }
  }
  /// Until `done` says so, at most `seconds`.
  bool Run(
      double seconds, const std::function<bool()>& done = [] { return false; }) {
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
      if (bench.CycleDue()) {
        Cycle();
      }
      const bool is_done = bench.CycleDue() && done();
      bench.Tick();
      if (is_done) {
        return true;
      }
    }
    return false;
  }
  bool ComesUp() {
    return Run(4, [this] { return report().phase == ControlPhase::kRunning; });
  }
  /// Turns, drives half a metre and moves the arm; the goal is where the sensor then is.
  void Order(std::uint32_t id, double sign = 1) {
    const Configuration from = report().state.q;
    Configuration to = from;
    to(0) += sign * 0.5 * std::cos(from(2));
    to(1) += sign * 0.5 * std::sin(from(2));
    to(2) += sign * 0.4;
    to.tail<kArmJoints>() += sign * ArmVector::LinSpaced(-0.4, 0.4);
    const Kinematics<kArmJoints> k(TracerUf7(), to);
    goal.id = id;
    goal.p_WS = k.p_WS();
    goal.z_WS = k.z_WS();
    goal.path.clear();
    EXPECT_TRUE(goal.path.push_back(from) && goal.path.push_back(to));
  }
  /// Everything at rest, and the newest command of every kind zero.
  void ExpectStandstill() {
    EXPECT_TRUE(bench.AtRest());
    ASSERT_FALSE(bench.twists.empty());
    EXPECT_EQ(bench.twists.back().v_mmps, 0);
    EXPECT_EQ(bench.twists.back().omega_mradps, 0);
    std::map<int, std::int32_t> newest;
    for (const SentJoint& sent : bench.joints) {
      newest[sent.joint] = sent.velocity_uradps;
    }
    for (const auto& [joint, velocity] : newest) {
      EXPECT_EQ(velocity, 0) << "joint " << joint;
    }
  }

  DeviceBench bench;
  std::unique_ptr<ControlTask> task;
  DistanceField field = EmptyHall();
  Scene scene;
  Goal goal;
  bool deaf = false;  ///< frames come and nobody reads them
};

/// Limits of the robot as it is operated: 0.4 m/s and 1 rad/s, 0.8 m/s^2 and 2 rad/s^2 for the
/// base; 1 rad/s and 10 rad/s^2 for each joint. A unit of each frame is allowed for rounding.
inline void ExpectWithinLimits(const DeviceBench& bench) {
  const SentTwist* before = nullptr;
  for (const SentTwist& sent : bench.twists) {
    ASSERT_LE(std::abs(sent.v_mmps), 400);
    ASSERT_LE(std::abs(sent.omega_mradps), 1000);
    if (before != nullptr) {
      // The base is sent every second cycle; the wire delays a frame by less than a millisecond.
      const double dt = 10e-3 * std::round(ToSeconds(sent.stamp - before->stamp) / 10e-3);
      ASSERT_LE(std::abs(sent.v_mmps - before->v_mmps), 800 * dt + 1);
      ASSERT_LE(std::abs(sent.omega_mradps - before->omega_mradps), 2000 * dt + 1);
    }
    before = &sent;
  }
  std::map<int, SentJoint> last;
  for (const SentJoint& sent : bench.joints) {
    ASSERT_LE(std::abs(sent.velocity_uradps), 1'000'001);
    if (last.contains(sent.joint)) {
      ASSERT_LE(std::abs(sent.velocity_uradps - last[sent.joint].velocity_uradps), 100'001);
    }
    last[sent.joint] = sent;
  }
}

}  // namespace pipewright::test
