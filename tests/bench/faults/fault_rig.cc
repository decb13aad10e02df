// SPDX-License-Identifier: MIT
#include "tests/bench/faults/fault_rig.h"

#include <cmath>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "platform/robot/kinematics.h"

namespace pipewright::bench {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

MapConfig Hall() {
  MapConfig config;
  config.lo = config.workspace_lo = {-30, -30, -2};
  config.hi = config.workspace_hi = {29, 29, 39};
  config.brick_capacity = 1;
  return config;
}

/// Cycles in which the envelope braked, and why it might.
std::uint64_t Stops(const EnvelopeCounters& n) {
  return n.not_finite + n.stale + n.invalid_state + n.emergency_stop + n.overrun_stop;
}

ControlTaskConfig HallConfig() {
  ControlTaskConfig config = TaskConfig({});
  config.law.reached = 0.01;
  return config;
}

}  // namespace

FaultRig::FaultRig(std::uint64_t seed, const ControlTaskConfig* config)
    : rng_(seed),
      inner_{hil::PortOf<can::LoopbackBus::Port>(bench_.base()),
             hil::PortOf<can::LoopbackBus::Port>(bench_.arm())},
      base_(std::make_unique<hil::FaultyPort>(inner_[0])),
      arm_(std::make_unique<hil::FaultyPort>(inner_[1])) {
  robot_ = std::make_unique<RobotSide>(config != nullptr ? *config : HallConfig(), Hall());
  VoxelGrid grid(Hall());
  grid.MarkSweptSphere(Vector3d::Zero(), 5);
  Surrounding& around = robot_->surrounding.Back();
  around.field.Update(grid);
  robot_->surrounding.Publish();
  StepClock({});
}

void FaultRig::StepClock(Duration by) {
  clock_ += by;
  base_->SetStampOffset(clock_);
  arm_->SetStampOffset(clock_);
}

void FaultRig::Tick() {
  script_.AdvanceTo(bench_.now());
  base_->AdvanceTo(bench_.now());
  arm_->AdvanceTo(bench_.now());
  if (bench_.CycleDue() && (!runs || runs())) {
    Cycle();
  }
  bench_.Tick();
  judge_.TakeAll(bench_);
  if (!rest_at_ && bench_.AtRest()) {
    rest_at_ = bench_.now();
  }
}

void FaultRig::Cycle() {
  ++cycles_;
  const hil::HeapWatch watch;
  const ControlReport& report = RunControlCycle(*robot_, *base_, *arm_, clock());
  cycles_that_allocate_ += watch.allocations() > 0 ? 1 : 0;
  const std::uint64_t stops = Stops(robot_->task.envelope_counters());
  if (!report.state.valid || report.phase == ControlPhase::kFault || stops > stops_) {
    Detected();
  }
  stops_ = stops;
  const bool done = report.progress.id == goal_.id && report.progress.state != GoalState::kMoving;
  if (report.state.valid && report.phase == ControlPhase::kRunning &&
      (goal_.id == 0 || done || bench_.now() > goal_end_)) {
    Order();
  }
}

/// To the other of two places half a metre apart, with other joints each time.
void FaultRig::Order() {
  const Configuration& q = robot_->task.report().state.q;
  home_ = home_.value_or(q);
  away_ = !away_;
  Configuration to = *home_;
  if (away_) {
    to(0) += 0.5 * std::cos((*home_)(2));
    to(1) += 0.5 * std::sin((*home_)(2));
    to(2) += 0.4;
  }
  for (int i = kDof - kArmJoints; i < kDof; ++i) {
    to(i) += rng_.Uniform(-0.4, 0.4);
  }
  const Kinematics<kArmJoints> k(TracerUf7(), to);
  ++goal_.id;
  goal_.p_WS = k.p_WS();
  goal_.z_WS = k.z_WS();
  goal_.path.clear();
  static_cast<void>(goal_.path.push_back(q) && goal_.path.push_back(to));
  goal_end_ = bench_.now() + 6s;
  robot_->goal.Write(goal_);
}

void FaultRig::For(Duration time) {
  for (const Time end = bench_.now() + time; bench_.now() < end;) {
    Tick();
  }
}

bool FaultRig::UnderWay() const {
  const hil::DeviceMotion& motion = bench_.motion();
  const bool moves =
      std::abs(motion.base.v_mps) > 0.1 || motion.joints_radps.cwiseAbs().maxCoeff() > 0.1;
  return moves && robot_->task.report().phase == ControlPhase::kRunning &&
         robot_->task.report().state.valid;
}

bool FaultRig::Ready() {
  const Time end = bench_.now() + 10s;
  Duration linger = 1ms * rng_.Index(300);
  while (bench_.now() < end) {
    const ControlPhase phase = robot_->task.report().phase;
    const bool down = phase == ControlPhase::kFault || phase == ControlPhase::kStopped ||
                      robot_->task.base().emergency_stop();
    if (down && bench_.CycleDue()) {
      static_cast<void>(robot_->task.Rearm());
      goal_end_ = {};  // a new order once it is up
    }
    Tick();
    if (!UnderWay()) {
      linger = std::max(linger, Duration{1ms});
    } else if (linger -= 1ms; linger <= Duration::zero()) {
      return true;
    }
  }
  return false;
}

bool FaultRig::Ready(Tally& tally) {
  const bool ready = Ready();
  if (!ready) {
    tally.Add(Outcome::kCrash);
    tally.Note("it did not come up again");
  }
  return ready;
}

void FaultRig::Begin() {
  fault_at_ = bench_.now();
  detected_.reset();
  rest_at_.reset();
  unlawful_before_ = judge_.unlawful();
  hard_stops_before_ = bench_.plant().hard_stops();
  allocated_before_ = cycles_that_allocate_;
  why_.clear();
}

std::optional<Duration> FaultRig::latency() const {
  return detected_ ? std::optional<Duration>(*detected_ - fault_at_) : std::nullopt;
}

Outcome FaultRig::Conclude(const Requirement& required) {
  For(fault_at_ + required.window - bench_.now());
  const bool stopped = rest_at_ && detected_;
  bool moved_again = false;
  if (stopped && required.stays) {
    for (const Time end = bench_.now() + required.hold; bench_.now() < end;) {
      Tick();
      moved_again = moved_again || !bench_.AtRest();
    }
  }
  if (judge_.unlawful() > unlawful_before_) {
    why_ = judge_.why();
    return Outcome::kWrong;
  }
  if (bench_.plant().hard_stops() > hard_stops_before_) {
    why_ = "a joint ran into its hard stop";
    return Outcome::kWrong;
  }
  if (cycles_that_allocate_ > allocated_before_) {
    why_ = "a cycle took memory from the heap";
    return Outcome::kWrong;
  }
  if (moved_again) {
    why_ = "it moved again before it was re-armed";
    return Outcome::kWrong;
  }
  if (stopped) {
    if (*rest_at_ - fault_at_ > required.bound) {
      why_ = "standstill after " + std::to_string((*rest_at_ - fault_at_) / 1ms) + " ms";
      return Outcome::kLate;
    }
    why_ = required.may_stop ? "" : "it stopped, and had no reason to";
    return Outcome::kSafeStop;
  }
  why_ = required.may_mask ? "" : "it never came to rest";
  return required.may_mask ? Outcome::kMasked : Outcome::kLate;
}

void FaultRig::Judge(const Requirement& required, const std::string& what, Tally& tally) {
  const Outcome outcome = Conclude(required);
  tally.Add(outcome);
  if (detected_) {
    tally.latencies_ms.push_back(1e3 * ToSeconds(*latency()));
  }
  if (!why_.empty()) {
    tally.Note(what + ": " + why_);
  }
}

}  // namespace pipewright::bench
