// SPDX-License-Identifier: MIT
// A bound of the instructions of one control cycle, from parts that are each counted at their
// largest, under QEMU with the plugin instruction_counter (scripts/bench worst):
//
//   outside the law   drivers, state, envelope, reports, with every receive queue full
//   law               all but its QPs: kinematics, every row, the way
//   rounds x around   posing a QP and checking its answer; a solve besides its iterations
//   rounds x cap x iteration
//   the end           shortening until every cone holds
//
// Each part is counted in forced cases (and, for the law, in cases that a search makes worse), not
// proved: the sum bounds a cycle as far as those are the largest.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "ctrl/constraints/svfi.h"
#include "tests/bench/control_loop.h"
#include "tests/timing/case_maker.h"
#include "tests/timing/case_runner.h"
#include "tests/timing/qp_bound.h"

namespace pipewright::timing {
namespace {

struct Options {
  std::uint64_t seed = 1;
  int cases = 100;
  int problems = 4;
  std::string start;
  std::uint64_t seen = 0;
  double rate_hz = 100;
};

/// Largest of what cases cost outside the QP solver.
struct LawCost {
  std::uint64_t law = 0;    ///< of a cycle, outside ChanceQp::Solve
  std::uint64_t round = 0;  ///< of ChanceQp::Solve, outside the solver, a round
  std::uint64_t cycle = 0;  ///< of all: the largest seen here
};

void See(const CycleCost& cycle, LawCost& cost) {
  cost.cycle = std::max(cost.cycle, cycle.instructions);
  cost.law = std::max(cost.law, cycle.instructions - cycle.in_chance);
  if (cycle.stats.qp.rounds > 0) {
    const auto rounds = static_cast<std::uint64_t>(cycle.stats.qp.rounds);
    cost.round = std::max(cost.round, (cycle.in_chance - cycle.in_solver) / rounds);
  }
}

/// From `start` and crowds, ever worse in what the law costs outside the QP.
LawCost MeasureLaw(const Options& options, const CycleCase& start,
                   const InstructionCount& instructions) {
  CaseRunner runner(instructions);
  CaseMaker maker(options.seed);
  LawCost all;
  std::uint64_t here_cost = 0;
  CycleCase here;
  const auto evaluate = [&](const CycleCase& c) {
    LawCost one;
    for (const CycleCost& cycle : runner.Run(c)) {
      See(cycle, one);
      See(cycle, all);
    }
    if (one.law + one.round >= here_cost) {
      here_cost = one.law + one.round;
      here = c;
    }
  };
  if (!start.steps.empty()) {
    evaluate(start);
  }
  for (int i = 0; i < options.cases; ++i) {
    evaluate(i < options.cases / 4 ? maker.Crowd(start) : maker.Mutate(here));
  }
  return all;
}

ChanceRow RandomRow(Rng& rng) {
  ChanceRow row;
  for (int j = 0; j < kControls; ++j) {
    row.a(j) = rng.Normal();
    row.J.col(j) = Vector3d{rng.Normal(), rng.Normal(), rng.Normal()};
  }
  const Vector3d root{rng.Normal(), rng.Normal(), rng.Normal()};
  row.cone.Q = root * root.transpose() + Matrix3d::Identity();
  row.cone.c = 1;
  return row;
}

/// When the rounds run out, for every row: it goes to its worst case, and what is sent is shortened
/// by 40 halvings, each a look at its cone.
std::uint64_t MeasureEnd(const InstructionCount& instructions, std::uint64_t seed) {
  constexpr int kLooks = 43;
  Rng rng(seed);
  std::uint64_t look = 0;
  std::uint64_t fall = 0;
  for (int i = 0; i < 100; ++i) {
    const ChanceRow row = RandomRow(rng);
    const Controls u = row.a.reverse();
    const std::uint64_t begin = instructions.Now();
    const volatile double excess = ChanceExcess(row, u, 0.5);
    const std::uint64_t middle = instructions.Now();
    const Row worst = WorstCaseRow(row, -u.cwiseAbs(), u.cwiseAbs(), excess);
    const volatile double hi = worst.hi;
    static_cast<void>(hi);
    look = std::max(look, middle - begin);
    fall = std::max(fall, instructions.Now() - middle);
  }
  return (kLooks * look + fall) * kMaxChanceRows;
}

struct FrameCost {
  std::uint64_t cycle = 0;  ///< of ControlCycle without a goal, its frames decoded
  std::uint64_t frame = 0;  ///< of one received frame
  int frames = 0;           ///< most that one cycle received
};

/// The cycle without a goal in an unknown world, on emulated devices, from switching on.
FrameCost MeasureFrames(const Options& options, const InstructionCount& instructions) {
  constexpr int kCycles = 300;
  FrameCost cost;
  const auto bench = std::make_unique<test::DeviceBench>();
  ControlTaskConfig config;
  config.law.constraints.period_s = 1 / options.rate_hz;
  config.arm.cycle_ms = std::max(10, static_cast<int>(1000 / options.rate_hz));
  const auto robot = std::make_unique<bench::RobotSide>(config, MapConfig{});
  const int ticks = static_cast<int>(1000 / options.rate_hz);
  for (int i = 0; i < kCycles; ++i) {
    can::Frame frame;
    std::vector<can::Frame> base;
    std::vector<can::Frame> arm;
    while (bench->base().Receive(frame)) {
      base.push_back(frame);
    }
    while (bench->arm().Receive(frame)) {
      arm.push_back(frame);
    }
    cost.frames = std::max(cost.frames, static_cast<int>(base.size() + arm.size()));
    for (const can::Frame& f : base) {
      const std::uint64_t before = instructions.Now();
      robot->task.OnBaseFrame(f);
      cost.frame = std::max(cost.frame, instructions.Now() - before);
    }
    for (const can::Frame& f : arm) {
      const std::uint64_t before = instructions.Now();
      robot->task.OnArmFrame(f);
      cost.frame = std::max(cost.frame, instructions.Now() - before);
    }
    const std::uint64_t before = instructions.Now();
    bench::ControlCycle(*robot, bench->base(), bench->arm(), bench->now());
    cost.cycle = std::max(cost.cycle, instructions.Now() - before);
    for (int t = 0; t < ticks; ++t) {
      bench->Tick();
    }
  }
  return cost;
}

int Run(const Options& options) {
  const InstructionCount instructions;
  if (!instructions.counting()) {
    fmt::print(stderr, "cycle_bound: nothing counts instructions; see scripts/bench worst\n");
    return 2;
  }
  CycleCase start;
  if (!options.start.empty()) {
    std::ifstream file(options.start);
    std::string error = "it cannot be opened";
    if (!file || !Read(file, start, error)) {
      fmt::print(stderr, "cycle_bound: {}: {}\n", options.start, error);
      return 2;
    }
  }
  start.period_s = 1 / options.rate_hz;
  QpSpy::Use(instructions);
  const auto progress = [](const char* what) { fmt::print(stderr, "cycle_bound: {}\n", what); };
  progress("frames");
  const FrameCost frames = MeasureFrames(options, instructions);
  progress("QP");
  const QpCost qp = MeasureQp(options.problems, options.seed);
  progress("law");
  const LawCost law = MeasureLaw(options, start, instructions);
  const std::uint64_t end = MeasureEnd(instructions, options.seed);

  constexpr int kCap =
      ChanceQp::kMaxIterations + WholeBodyConfig{}.svfi_rounds + 1;  // one past it a QP
  const int rounds = WholeBodyConfig{}.svfi_rounds + 1;  // and one with rows at their worst case
  constexpr int kQueues = 2 * can::LoopbackBus::kRxCapacity;
  const std::uint64_t outside = frames.cycle + kQueues * frames.frame;
  constexpr std::uint64_t kStarts = 2;  // from what is remembered, and if that fails from nothing
  const auto bound = [&](int iterations, int rounds_counted) {
    const auto n = static_cast<std::uint64_t>(rounds_counted);
    return outside + law.law + end + n * (law.round + kStarts * qp.around) +
           static_cast<std::uint64_t>(iterations) * qp.iteration;
  };
  const std::uint64_t seen = std::max(options.seen, law.cycle);
  const auto row = [](const char* what, std::uint64_t n, const std::string& how) {
    fmt::print("{:<34} {:>13}  {}\n", what, n, how);
  };
  row("outside the law", outside,
      fmt::format("{} without a frame, {} queued x {}; {} frames at most were met", frames.cycle,
                  kQueues, frames.frame, frames.frames));
  row("law without its QPs", law.law, fmt::format("largest of {} forced cases", options.cases));
  row("a round besides its solve", law.round, "largest mean of a forced case");
  row("a solve besides its iterations", qp.around,
      fmt::format("largest of {} forced problems; taken twice", options.problems));
  row("an iteration", qp.iteration,
      fmt::format("{} rows, {} active, {} iterations at most", kMaxRows, qp.active_max,
                  qp.iterations_max));
  row("an iteration, median", qp.iteration_median, "not in the bound");
  row("the end", end, fmt::format("{} cones shortened", kMaxChanceRows));
  row("bound", bound(kCap, rounds), fmt::format("{} rounds, {} iterations", rounds, kCap));
  row("largest seen", seen, "");
  fmt::print("{:<34} {:>13.1f}\n", "bound / largest seen",
             static_cast<double>(bound(kCap, rounds)) / static_cast<double>(seen));
  return 0;
}

}  // namespace
}  // namespace pipewright::timing

int main(int argc, char** argv) {
  pipewright::timing::Options options;
  CLI::App app("A bound of the instructions of one control cycle, part by part", "cycle_bound");
  app.add_option("--seed", options.seed)->capture_default_str();
  app.add_option("--cases", options.cases, "that force the law's part")->capture_default_str();
  app.add_option("--problems", options.problems, "that force the QP's part")->capture_default_str();
  app.add_option("--start", options.start, "a case of worst_cycle to begin with");
  app.add_option("--seen", options.seen, "instructions of the largest cycle seen");
  app.add_option("--rate", options.rate_hz, "of the control law [Hz]")
      ->check(CLI::Range(50.0, 1000.0))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return pipewright::timing::Run(options);
}
