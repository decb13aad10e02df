// SPDX-License-Identifier: MIT
// How deep the stack of the control cycle goes: every cycle of a closed loop runs on a stack of its
// own that was painted before, and what is no longer paint was used. scripts/stack holds it against
// the bound from the call graph.
#include <fmt/core.h>
#include <ucontext.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <memory>

#include "tests/bench/control_loop.h"

namespace pipewright::timing {
namespace {

using Port = can::LoopbackBus::Port;

constexpr std::size_t kBytes = 1 << 20;
constexpr std::uint64_t kPaint = 0xA5C3'965A'F00D'1234;

/// Runs a function on a painted stack; none of it allocates.
class PaintedStack {
 public:
  PaintedStack() : words_(std::make_unique<std::uint64_t[]>(kBytes / sizeof(std::uint64_t))) {
    std::fill_n(words_.get(), kBytes / sizeof(std::uint64_t), kPaint);
  }

  /// `run` is a function without state, as a thread's is.
  void Run(void (*run)()) {
    getcontext(&there_);
    there_.uc_stack.ss_sp = words_.get();
    there_.uc_stack.ss_size = kBytes;
    there_.uc_link = &here_;
    makecontext(&there_, run, 0);
    swapcontext(&here_, &there_);
  }

  std::size_t UsedBytes() const {
    const std::uint64_t* const end = words_.get() + kBytes / sizeof(std::uint64_t);
    const std::uint64_t* const used =
        std::find_if(static_cast<const std::uint64_t*>(words_.get()), end,
                     [](std::uint64_t word) { return word != kPaint; });
    return static_cast<std::size_t>(end - used) * sizeof(std::uint64_t);
  }

 private:
  std::unique_ptr<std::uint64_t[]> words_;
  ucontext_t here_{};
  ucontext_t there_{};
};

/// What the function on the painted stack is given, and what it answers.
struct Call {
  bench::RobotSide* robot = nullptr;
  Port* base = nullptr;
  Port* arm = nullptr;
  Time now{};
  const ControlReport* report = nullptr;
};
Call call;

void RunCycle() {
  call.report = &bench::ControlCycle(*call.robot, *call.base, *call.arm, call.now);
}

void RunNothing() {}

int Measure(int cycles, std::uint64_t seed, double rate_hz) {
  bench::ControlLoop loop(rate_hz, seed, nullptr);
  PaintedStack nothing;
  nothing.Run(RunNothing);
  if (!loop.Start()) {
    fmt::print(stderr, "stack_use: the devices did not come up\n");
    return 1;
  }
  PaintedStack stack;
  int rows = 0;
  for (int i = 0; i < cycles; ++i) {
    const auto painted = [&](bench::RobotSide& robot, Port& base, Port& arm,
                             Time now) -> const ControlReport& {
      call = {&robot, &base, &arm, now, nullptr};
      stack.Run(RunCycle);
      rows = std::max(rows, call.report->stats.rows);
      return *call.report;
    };
    if (!loop.Cycle(painted)) {
      fmt::print(stderr, "stack_use: a device is at fault\n");
      return 1;
    }
  }
  fmt::print("closed-loop cycles    {}, seed {}, {} rows at most\n", cycles, seed, rows);
  fmt::print("stack used            {} bytes, besides {} of an empty function\n",
             stack.UsedBytes() - nothing.UsedBytes(), nothing.UsedBytes());
  return 0;
}

}  // namespace
}  // namespace pipewright::timing

int main(int argc, char** argv) {
  int cycles = 5000;
  std::uint64_t seed = 1;
  double rate_hz = 100;
  CLI::App app("How deep the stack of the control cycle goes, in closed loop", "stack_use");
  app.add_option("--cycles", cycles)->check(CLI::Range(1, 100000000))->capture_default_str();
  app.add_option("--seed", seed, "of the goals")->capture_default_str();
  app.add_option("--rate", rate_hz, "cycles a second [Hz]")
      ->check(CLI::Range(50.0, 1000.0))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return pipewright::timing::Measure(cycles, seed, rate_hz);
}
