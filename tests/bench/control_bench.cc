// SPDX-License-Identifier: MIT
// What one whole control cycle costs in closed loop, frames in to frames out (ControlCycle), among
// so many surfaces that most cycles have 120 rows or more. It goes on until so many of these were
// counted (_120_rows); the others on the way are in the figures of all. The devices and the bodies
// they move are not timed. Compare only figures of one machine.
//
// preempted_cycles: the scheduler ran something else in between; _undisturbed is of the others. But
// nobody tells when the machine itself is a guest whose host does so. Therefore the same cycles run
// in several passes, whose every frame is the same, and own_us is the least time of each cycle.
// With --count and callgrind they are counted in instructions, which no other load disturbs.
#include <fmt/core.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "hil/cli/bus_choice.h"
#include "hil/cli/heap_watch.h"
#include "tests/bench/control_figures.h"
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

struct Options {
  int cycles = 100000;
  int passes = 2;
  int count = 0;
  double rate_hz = 100;
  std::uint64_t seed = 1;
  std::string record;
  int skip = 0;
  bool json = false;
};

/// A run gives up when fewer than one cycle in so many has the rows that are asked for.
constexpr int kPatience = 10;

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
  void Report(int pass, int done, int of) {
    if (WallClock::now() < next_) {
      return;
    }
    next_ = WallClock::now() + std::chrono::seconds(5);
    fmt::print(stderr, "pass {}: {}/{} cycles\n", pass, done, of);
  }

 private:
  WallClock::time_point next_ = WallClock::now() + std::chrono::seconds(5);
};

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

/// One pass's timed cycles: what came of each goes to `take`, which says whether to go on.
template <typename Take>
int Pass(const Options& options, Json& json, const Take& take) {
  ControlLoop loop(options.rate_hz, options.seed, WallNanoseconds);
  if (!loop.Start()) {
    return Complain("the devices did not come up", loop);
  }
  std::uint64_t allocations = 0;
  bool more = true;
  const auto timed = [&](RobotSide& robot, Port& base, Port& arm,
                         Time now) -> const ControlReport& {
    const long preemptions = Preemptions();
    const hil::HeapWatch heap;
    const WallClock::time_point start = WallClock::now();
    const ControlReport& report = ControlCycle(robot, base, arm, now);
    const WallClock::time_point end = WallClock::now();
    allocations += heap.allocations();
    more = take(report, std::chrono::duration<double, std::micro>(end - start).count(),
                Preemptions() != preemptions);
    return report;
  };
  while (more) {
    if (!loop.Cycle(timed)) {
      return Complain("a device is at fault", loop);
    }
  }
  json = {{"goals", loop.goals()},
          {"goals_reached", loop.goals_reached()},
          {"send_failures", loop.robot().buses.send_failures},
          {"heap_counted", hil::HeapWatch::Counting()},
          {"heap_allocations", allocations}};
  return allocations > 0 ? 1 : 0;
}

int Measure(const Options& options) {
  ControlFigures figures;
  figures.Reserve(2 * options.cycles);
  Progress progress;
  Json of_loop;
  int exit_code = Pass(options, of_loop, [&](const ControlReport& report, double us, bool lost) {
    figures.Add(report, us, lost);
    progress.Report(1, figures.many_rows(), options.cycles);
    return figures.many_rows() < options.cycles &&
           figures.cycles() < static_cast<std::size_t>(options.cycles) * kPatience;
  });
  bool same = true;
  for (int pass = 2; pass <= options.passes && exit_code == 0; ++pass) {
    std::size_t i = 0;
    Json ignored;
    exit_code = Pass(options, ignored, [&](const ControlReport& report, double us, bool) {
      same = figures.Repeat(i++, report, us) && same;
      progress.Report(pass, static_cast<int>(i), static_cast<int>(figures.cycles()));
      return i < figures.cycles();
    });
  }
  Json json = {{"seed", options.seed}, {"rate_hz", options.rate_hz}, {"passes", options.passes}};
  json.update(figures.ToJson());
  json.update(of_loop);
  if (options.json) {
    fmt::print("{}\n", json.dump(2));
  } else {
    Print(json);
  }
  if (!same || figures.many_rows() < options.cycles) {
    fmt::print(stderr, "bench_control: {}\n",
               same ? "too few cycles have 120 rows" : "the passes are not the same");
    return 1;
  }
  return exit_code;
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
  app.add_option("--cycles", options.cycles,
                 "cycles of 120 rows or more that are timed, and in each pass all of those between")
      ->check(CLI::Range(1, 100000000))
      ->capture_default_str();
  app.add_option("--passes", options.passes, "over the same cycles")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--count", options.count,
                 "instead, that many cycles without a clock, for callgrind; see scripts/bench "
                 "control --instructions")
      ->check(CLI::Range(1, 20000));
  app.add_option("--record", options.record,
                 "instead, --cycles of any rows to this file, for replay_cycles");
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
