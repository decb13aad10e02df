// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hil/cli/heap_watch.h"
#include "hil/faults/fault_script.h"
#include "hil/faults/faulty_port.h"
#include "platform/core/rng.h"
#include "tests/bench/faults/command_judge.h"
#include "tests/bench/faults/outcome.h"
#include "tests/bench/robot_side.h"
#include "tests/ctrl/robot_program/device_bench.h"

namespace pipewright::bench {

/// What is required of a case.
struct Requirement {
  bool may_mask = true;                              ///< else the robot must come to rest
  bool may_stop = true;                              ///< else it is noted that it did
  bool stays = false;                                ///< at rest until it is re-armed, for `hold`
  Duration bound = std::chrono::milliseconds(700);   ///< from the fault to standstill
  Duration window = std::chrono::milliseconds(900);  ///< that a case is watched for
  Duration hold = std::chrono::milliseconds(400);
};

/// The control task at 100 Hz and the emulated devices, each on a wire that can be at fault, in
/// virtual time. The robot goes to and fro in an empty hall: base and joints move.
///
///   FaultRig rig(seed);
///   while (...) {
///     if (!rig.Ready()) ...            // up, armed, under way; from whatever was before
///     rig.Begin();                     // the fault is now
///     rig.arm().Lose(7, Any);
///     tally.Add(rig.Conclude({}));
///   }
///
/// Standstill is the devices' own: what their motors do, not what was commanded or reported.
class FaultRig {
 public:
  explicit FaultRig(std::uint64_t seed, const ControlTaskConfig* config = nullptr);

  /// Re-arms if need be, brings up, sets out, and lets up to 300 ms pass under way. False: 10 s
  /// were not enough.
  bool Ready();
  /// False goes into the tally, as a crash.
  bool Ready(Tally& tally);
  void Begin();
  Outcome Conclude(const Requirement& required);
  /// Adds what Conclude() says to the tally, with the latency, and what was wrong in words.
  void Judge(const Requirement& required, const std::string& what, Tally& tally);
  void For(Duration time);
  void Tick();

  hil::FaultyPort& base() { return *base_; }
  hil::FaultyPort& arm() { return *arm_; }
  test::DeviceBench& bench() { return bench_; }
  ControlTask& task() { return robot_->task; }
  const BusCounters& buses() const { return robot_->buses; }
  /// For goals and scenes at fault; what is put there the next Ready() replaces.
  RobotSide& robot() { return *robot_; }
  Goal& goal() { return goal_; }
  hil::FaultScript& script() { return script_; }
  Rng& rng() { return rng_; }

  /// Whether the program gets its cycle. Empty: always.
  std::function<bool()> runs;
  /// Added to the program's clock: its `now` and the stamps of its frames.
  void StepClock(Duration by);
  Time clock() const { return bench_.now() + clock_; }
  std::optional<Duration> latency() const;
  /// Seen otherwise than by the program's own report.
  void Detected() { detected_ = detected_ ? detected_ : bench_.now(); }
  std::uint64_t cycles() const { return cycles_; }
  /// Of them, those that took anything from the heap; each is a W, too.
  std::uint64_t cycles_that_allocate() const { return cycles_that_allocate_; }
  /// The next order is due: what was in hand is put aside.
  void Renew() { goal_end_ = {}; }
  const std::string& why() const { return why_; }

 private:
  bool UnderWay() const;
  void Order();
  void Cycle();

  Rng rng_;
  test::DeviceBench bench_;
  hil::PortOf<can::LoopbackBus::Port> inner_[2];
  std::unique_ptr<hil::FaultyPort> base_;
  std::unique_ptr<hil::FaultyPort> arm_;
  std::unique_ptr<RobotSide> robot_;
  hil::FaultScript script_;
  CommandJudge judge_;
  Goal goal_;
  bool away_ = false;  ///< the goal is that other place, not the first
  Time goal_end_{};
  Duration clock_ = std::chrono::hours(2);
  std::optional<Configuration> home_;
  std::uint64_t cycles_ = 0;
  std::uint64_t cycles_that_allocate_ = 0;
  std::uint64_t allocated_before_ = 0;
  std::uint64_t stops_ = 0;
  Time fault_at_{};
  std::optional<Time> detected_;
  std::optional<Time> rest_at_;
  std::uint64_t unlawful_before_ = 0;
  int hard_stops_before_ = 0;
  std::string why_;
};

}  // namespace pipewright::bench
