// SPDX-License-Identifier: MIT
// What one whole control cycle costs in closed loop, frames in to frames out (ControlCycle), among
// so many surfaces that most cycles have 120 rows or more. The devices and the bodies they move are
// not timed. Compare only figures of one machine.
//
// rows: as the QP is first posed, one for each chance row. preempted_cycles: the scheduler ran
// something else in between; cycle_us max_undisturbed is of the others. With --count and callgrind
// the same cycles are counted in instructions, which no other load disturbs.
#include <fmt/core.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hil/cli/bus_choice.h"
#include "hil/cli/heap_watch.h"
#include "tests/bench/control_loop.h"
#include "tests/timing/replay/recorder.h"

#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#define PIPEWRIGHT_CALLGRIND 1
#else
#define PIPEWRIGHT_CALLGRIND 0
#endif

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;
using WallClock = std::chrono::steady_clock;
using Port = can::LoopbackBus::Port;

constexpr int kManyRows = 120;
constexpr double kStill = 0.01;  ///< no control above this [m/s, rad/s]: the robot stands

struct Options {
  int cycles = 100000;
  int count = 0;
  double rate_hz = 100;
  std::uint64_t seed = 1;
  std::string record;
  int skip = 0;
  bool json = false;
};

struct Figures {
  std::vector<float> cycle_us;
  std::vector<float> qp_us;
  std::vector<float> rows;
  int many_rows = 0;  ///< cycles with kManyRows or more
  int moving = 0;
  int clamped = 0;  ///< cycles in which a hard row was at its clamp
  int invalid = 0;  ///< cycles without a valid state: the law did nothing
  int dropped_rows_max = 0;
  int rounds_max = 0;
  int iterations_max = 0;
  int cap_hits = 0;
  int not_optimal = 0;  ///< cap hits and whatever else is no optimum
  int fallbacks = 0;
  int preempted = 0;  ///< cycles in which the machine did something else
  double undisturbed_max_us = 0;
  std::uint64_t allocations = 0;

  void Reserve(int cycles);
  void Add(const ControlReport& report, double us, bool preempted_now);
};

void Figures::Reserve(int cycles) {
  for (std::vector<float>* values : {&cycle_us, &qp_us, &rows}) {
    values->reserve(static_cast<std::size_t>(cycles));
  }
}

void Figures::Add(const ControlReport& report, double us, bool preempted_now) {
  const ControlStats& stats = report.stats;
  cycle_us.push_back(static_cast<float>(us));
  preempted += preempted_now ? 1 : 0;
  undisturbed_max_us = preempted_now ? undisturbed_max_us : std::max(undisturbed_max_us, us);
  qp_us.push_back(1e-3F * static_cast<float>(stats.qp_ns));
  rows.push_back(static_cast<float>(stats.rows));
  many_rows += stats.rows >= kManyRows ? 1 : 0;
  moving += report.sent.cwiseAbs().maxCoeff() > kStill ? 1 : 0;
  clamped += stats.clamped_rows > 0 ? 1 : 0;
  invalid += report.state.valid ? 0 : 1;
  dropped_rows_max = std::max(dropped_rows_max, stats.dropped_rows);
  rounds_max = std::max(rounds_max, stats.qp.rounds);
  iterations_max = std::max(iterations_max, stats.qp.iterations);
  cap_hits += stats.qp.status == QpStatus::kCapped ? 1 : 0;
  not_optimal += stats.qp.status == QpStatus::kOptimal ? 0 : 1;
  fallbacks += stats.qp.fallbacks;
}

/// How often the scheduler has taken the processor from this thread so far.
long Preemptions() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

std::int64_t WallNanoseconds() { return WallClock::now().time_since_epoch().count(); }

/// Every few seconds, for whoever waits.
class Progress {
 public:
  void Report(int done, int of) {
    if (WallClock::now() < next_) {
      return;
    }
    next_ = WallClock::now() + std::chrono::seconds(5);
    fmt::print(stderr, "{}/{} cycles\n", done, of);
  }

 private:
  WallClock::time_point next_ = WallClock::now() + std::chrono::seconds(5);
};

/// The smallest value that at least a share p does not exceed; 0 for none.
double Percentile(std::vector<float>& values, double p) {
  if (values.empty()) {
    return 0;
  }
  const double rank = std::ceil(p * static_cast<double>(values.size()));
  const auto k = static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return static_cast<double>(values[static_cast<std::size_t>(k)]);
}

Json ToJson(const Options& options, const ControlLoop& loop, Figures& f) {
  const auto cycles = f.cycle_us.size();
  const auto share = [&](int part) {
    return cycles == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(cycles);
  };
  return {{"seed", options.seed},
          {"rate_hz", options.rate_hz},
          {"cycles", cycles},
          {"rows", {{"p50", Percentile(f.rows, 0.5)}, {"max", Percentile(f.rows, 1)}}},
          {"share_120_rows", share(f.many_rows)},
          {"share_moving", share(f.moving)},
          {"share_clamped", share(f.clamped)},
          {"invalid_states", f.invalid},
          {"dropped_rows_max", f.dropped_rows_max},
          {"goals", loop.goals()},
          {"goals_reached", loop.goals_reached()},
          {"cycle_us",
           {{"p50", Percentile(f.cycle_us, 0.5)},
            {"p99", Percentile(f.cycle_us, 0.99)},
            {"p99.99", Percentile(f.cycle_us, 0.9999)},
            {"max", Percentile(f.cycle_us, 1)},
            {"max_undisturbed", f.undisturbed_max_us}}},
          {"preempted_cycles", f.preempted},
          {"qp_us",
           {{"p50", Percentile(f.qp_us, 0.5)},
            {"p99", Percentile(f.qp_us, 0.99)},
            {"max", Percentile(f.qp_us, 1)}}},
          {"qp_rounds_max", f.rounds_max},
          {"qp_iterations_max", f.iterations_max},
          {"qp_cap_hits", f.cap_hits},
          {"qp_not_optimal", f.not_optimal},
          {"svfi_fallbacks", f.fallbacks},
          {"send_failures", loop.robot().send_failures},
          {"heap_counted", hil::HeapWatch::Counting()},
          {"heap_allocations", f.allocations}};
}

/// A line a figure: its path, then its value.
void Print(const Json& json, const std::string& prefix = "") {
  for (const auto& [key, value] : json.items()) {
    if (value.is_object()) {
      Print(value, prefix + key + " ");
    } else if (value.is_number_float()) {
      fmt::print("{:<24} {:.4g}\n", prefix + key, value.get<double>());
    } else {
      fmt::print("{:<24} {}\n", prefix + key, value.dump());
    }
  }
}

int Complain(const char* what, const ControlLoop& loop) {
  const ControlReport& report = loop.robot().task.report();
  fmt::print(stderr, "bench_control: {} at {:.3f} s: base problem {}, arm problem {} of joint {}\n",
             what, ToSeconds(loop.now()), static_cast<int>(report.base_fault.problem),
             static_cast<int>(report.arm_fault.problem), report.arm_fault.node);
  return 1;
}

int Measure(const Options& options) {
  ControlLoop loop(options.rate_hz, options.seed, WallNanoseconds);
  if (!loop.Start()) {
    return Complain("the devices did not come up", loop);
  }
  Figures figures;
  figures.Reserve(options.cycles);
  const auto timed = [&figures](RobotSide& robot, Port& base, Port& arm,
                                Time now) -> const ControlReport& {
    const long preemptions = Preemptions();
    const hil::HeapWatch heap;
    const WallClock::time_point start = WallClock::now();
    const ControlReport& report = ControlCycle(robot, base, arm, now);
    const WallClock::time_point end = WallClock::now();
    figures.allocations += heap.allocations();
    figures.Add(report, std::chrono::duration<double, std::micro>(end - start).count(),
                Preemptions() != preemptions);
    return report;
  };
  Progress progress;
  for (int i = 0; i < options.cycles; ++i) {
    progress.Report(i, options.cycles);
    if (!loop.Cycle(timed)) {
      return Complain("a device is at fault", loop);
    }
  }
  const Json json = ToJson(options, loop, figures);
  if (options.json) {
    fmt::print("{}\n", json.dump(2));
  } else {
    Print(json);
  }
  return figures.allocations > 0 ? 1 : 0;
}

/// Cycles for an instruction counter: no clock, and after each a dump of what it counted.
int Count(const Options& options) {
#if PIPEWRIGHT_CALLGRIND
  ControlLoop loop(options.rate_hz, options.seed, nullptr);
  if (!loop.Start()) {
    return Complain("the devices did not come up", loop);
  }
  CALLGRIND_ZERO_STATS;  // what it took to come up
  for (int i = 0; i < options.count; ++i) {
    const auto counted = [](RobotSide& robot, Port& base, Port& arm,
                            Time now) -> const ControlReport& {
      const ControlReport& report = ControlCycle(robot, base, arm, now);
      CALLGRIND_DUMP_STATS;  // and back to zero
      return report;
    };
    if (!loop.Cycle(counted)) {
      return Complain("a device is at fault", loop);
    }
  }
  return 0;
#else
  static_cast<void>(options);
  fmt::print(stderr, "bench_control: --count needs <valgrind/callgrind.h> when it is built\n");
  return 2;
#endif
}

/// Cycles without a clock, for replay_cycles.
int RecordTo(const Options& options) {
  ControlLoop loop(options.rate_hz, options.seed, nullptr);
  std::FILE* file = std::fopen(options.record.c_str(), "wb");
  if (file == nullptr) {
    fmt::print(stderr, "bench_control: {}: {}\n", options.record, std::strerror(errno));
    return 2;
  }
  const char* problem = timing::Record(loop, options.seed, options.skip, options.cycles, file);
  const bool closed = std::fclose(file) == 0;
  return problem == nullptr && closed ? 0
                                      : Complain(problem != nullptr ? problem : "no room", loop);
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  pipewright::bench::Options options;
  CLI::App app("The whole control cycle in closed loop with the emulated devices", "bench_control");
  app.add_option("--cycles", options.cycles, "cycles that are timed")
      ->check(CLI::Range(1, 100000000))
      ->capture_default_str();
  app.add_option("--count", options.count,
                 "instead, that many cycles without a clock, for callgrind; see scripts/bench "
                 "control --instructions")
      ->check(CLI::Range(1, 20000));
  app.add_option("--record", options.record,
                 "instead, --cycles of them to this file, for replay_cycles");
  app.add_option("--skip", options.skip, "cycles before, which are recorded but not counted")
      ->check(CLI::Range(0, 1000000));
  app.add_option("--rate", options.rate_hz, "cycles a second [Hz], of whole milliseconds")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of the goals")->capture_default_str();
  app.add_flag("--json", options.json, "one JSON object on stdout");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  const std::string error = pipewright::hil::RateError(options.rate_hz, false);
  if (!error.empty()) {
    fmt::print(stderr, "bench_control: {}\n", error);
    return 2;
  }
  return !options.record.empty() ? pipewright::bench::RecordTo(options)
         : options.count > 0     ? pipewright::bench::Count(options)
                                 : pipewright::bench::Measure(options);
}
