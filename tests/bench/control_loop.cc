// SPDX-License-Identifier: MIT
#include "tests/bench/control_loop.h"

#include <cmath>

#include "ctrl/robot_program/control_rate.h"
#include "plan/motion/inverse_kinematics.h"

namespace pipewright::bench {
namespace {

constexpr Duration kWayTime = std::chrono::seconds(15);  ///< for a planned goal; then the next
constexpr Duration kPushTime = std::chrono::seconds(3);  ///< for one without a way
constexpr int kTargets = 20;                             ///< drawn for one planned goal, at most

/// Deviations of what the depth camera shows of a surface a metre away.
constexpr double kPlaneTilt_rad = 0.004;
constexpr double kPlaneOffset_m = 0.003;
constexpr double kAxisPlace_m = 0.004;
constexpr double kAxisTilt_rad = 0.01;
constexpr double kRadius_m = 0.003;

LoopConfig ConfigAt(double rate_hz) {
  const Configuration start = test::Cell::Start();
  return {.period_s = 1 / rate_hz,
          .arm_cycle_ms = ArmCycle_ms(rate_hz, false),
          .x_m = start(0),
          .y_m = start(1),
          .phi_rad = start(2)};
}

/// n turns by tilt about the rectangle's axes through its centroid, and d shifts: (n, d) of rank 3.
void MakeUncertain(PlaneEstimate& plane) {
  Mat<4, 3> G = Mat<4, 3>::Zero();
  G.col(0) << plane.e1_W, plane.e1_W.dot(plane.p_WCentroid);
  G.col(1) << plane.e2_W, plane.e2_W.dot(plane.p_WCentroid);
  G.leftCols<2>() *= kPlaneTilt_rad;
  G(3, 2) = kPlaneOffset_m;
  plane.covariance = G * G.transpose();
}

/// (p, l, r) of rank 5: p and l move across the axis only.
void MakeUncertain(PipeEstimate& pipe) {
  const Vector3d e1_W = pipe.l_W.unitOrthogonal();
  const Vector3d e2_W = pipe.l_W.cross(e1_W);
  Mat<7, 5> G = Mat<7, 5>::Zero();
  G.block<3, 1>(0, 0) = kAxisPlace_m * e1_W;
  G.block<3, 1>(0, 1) = kAxisPlace_m * e2_W;
  G.block<3, 1>(3, 2) = kAxisTilt_rad * e1_W;
  G.block<3, 1>(3, 3) = kAxisTilt_rad * e2_W;
  G(6, 4) = kRadius_m;
  pipe.covariance = G * G.transpose();
}

/// The product's cell of three pipes, seven more and a ceiling: wherever it works, the arm has most
/// of them near.
void Furnish(test::Cell& cell) {
  cell.AddThreePipes();
  cell.AddPipe({0, 1.3, 1.1}, {1.5, 1.3, 1.1}, 0.04);
  cell.AddPipe({0.1, 0, 1.4}, {0.1, 1.5, 1.4}, 0.05);
  cell.AddPipe({1.35, 0.35, 0}, {1.35, 0.35, 1.5}, 0.05);
  cell.AddPipe({0.7, 0, 1.35}, {0.7, 1.5, 1.35}, 0.04);
  cell.AddPipe({0, 0.7, 1.45}, {1.5, 0.7, 1.45}, 0.04);
  cell.AddPipe({0, 0.1, 0.3}, {1.5, 0.1, 0.3}, 0.05);
  cell.AddPipe({0, 1.4, 0.5}, {1.5, 1.4, 0.5}, 0.05);
  cell.AddPipe({0.55, 0, 1.45}, {0.55, 1.5, 1.45}, 0.04);
  cell.AddPipe({1.1, 0, 1.35}, {1.1, 1.5, 1.35}, 0.04);
  cell.AddPipe({0, 1.4, 0.8}, {1.5, 1.4, 0.8}, 0.05);
  cell.AddPipe({0, 0.1, 1.0}, {1.5, 0.1, 1.0}, 0.05);
  cell.AddPipe({1.4, 0, 0.5}, {1.4, 1.5, 0.5}, 0.05);
  cell.AddPipe({1.38, 0, 1.25}, {1.38, 1.5, 1.25}, 0.05);
  cell.AddBox({0, 0, 1.56}, {1.5, 1.5, 1.59});
  cell.AddPlane({0.75, 0.75, 1.55}, Vector3d::UnitY(), Vector3d::UnitX(), 0.75, 0.75);
  for (PlaneEstimate& plane : cell.scene().planes) {
    for (const int i : {0, 1}) {
      plane.extent_lo_m[i] -= 1;
      plane.extent_hi_m[i] += 1;
    }
    MakeUncertain(plane);
  }
  for (PipeEstimate& pipe : cell.scene().pipes) {
    MakeUncertain(pipe);
  }
}

}  // namespace

const ControlReport& ControlCycle(RobotSide& robot, can::LoopbackBus::Port& base,
                                  can::LoopbackBus::Port& arm, Time now) {
  return RunControlCycle(robot, base, arm, now);
}

bool GoalMaker::TryWay(const Configuration& from) {
  const Surroundings around = cell_.around();
  const CollisionChecker checker(around);
  const SensorTarget target{
      {rng_.Uniform(0.1, 1.3), rng_.Uniform(0.2, 1.3), rng_.Uniform(0.2, 1.3)},
      Vector3d{rng_.Normal(), rng_.Normal(), rng_.Normal()}.normalized()};
  const std::optional<Configuration> to = Reach(checker, target, from, rng_);
  double duration_s = 0;
  if (!to || planner_.Plan(around, from, *to, rng_, goal_.path, &duration_s) != Status::kOk) {
    return false;
  }
  goal_.p_WS = target.p_WS;
  goal_.z_WS = target.z_WS;
  free_ = *to;
  return true;
}

void GoalMaker::Push(const Configuration& from) {
  const Kinematics<kArmJoints> k(TracerUf7(), from);
  goal_.path.clear();
  goal_.p_WS = k.p_WS() + rng_.Uniform(0.1, 0.4) * k.z_WS();
  goal_.z_WS = k.z_WS();
}

void GoalMaker::GoBack(const Configuration& from) {
  const Kinematics<kArmJoints> k(TracerUf7(), free_);
  goal_.path.clear();
  static_cast<void>(goal_.path.push_back(from) && goal_.path.push_back(free_));
  goal_.p_WS = k.p_WS();
  goal_.z_WS = k.z_WS();
}

const Goal& GoalMaker::Next(const Configuration& from) {
  ++goal_.id;
  if (has_way_) {
    has_way_ = false;
    Push(from);
    return goal_;
  }
  for (int i = 0; !has_way_ && i < kTargets; ++i) {
    has_way_ = TryWay(from);
  }
  if (!has_way_) {
    GoBack(from);
  }
  return goal_;
}

ControlLoop::ControlLoop(double rate_hz, std::uint64_t seed, std::int64_t (*stopwatch)())
    : config_(ConfigAt(rate_hz)), ticks_(static_cast<int>(std::lround(1000 / rate_hz))) {
  Furnish(cell_);
  ControlTaskConfig task = TaskConfig(config_);
  task.law.stopwatch = stopwatch;
  robot_ = std::make_unique<RobotSide>(task, cell_.map().config());
  Surrounding& around = robot_->surrounding.Back();
  around.scene = cell_.scene();
  around.field = cell_.around().field;
  robot_->surrounding.Publish();
  maker_ = std::make_unique<GoalMaker>(cell_, seed);
}

void ControlLoop::Direct(const ControlReport& report) {
  const bool current = report.progress.id == static_cast<std::uint32_t>(goals_);
  if (!report.state.valid || !current) {
    return;
  }
  const bool reached = report.progress.state == GoalState::kReached;
  if (goals_ > 0 && !reached && report.progress.state != GoalState::kStalled &&
      report.now < goal_end_) {
    return;
  }
  goals_reached_ += reached ? 1 : 0;
  ++goals_;
  const Goal& goal = maker_->Next(report.state.q);
  goal_end_ = report.now + (goal.path.empty() ? kPushTime : kWayTime);
  robot_->goal.Write(goal);
}

void ControlLoop::Advance() {
  for (int i = 0; i < ticks_; ++i) {
    bench_.Tick();
  }
  bench_.twists.clear();  // the bench keeps every command for its tests
  bench_.joints.clear();
}

}  // namespace pipewright::bench
