// SPDX-License-Identifier: MIT
// Looks for the control cycle that takes the most instructions: random restarts, each followed by
// changes of which the better are kept, over places, surfaces, voxels, set points, ways and what
// the law remembers. The instructions are counted exactly under QEMU with the plugin
// instruction_counter (scripts/bench worst); without it, work is sought instead, by a formula.
// What is found is kept in files that --replay runs again; so is the first case of each trouble.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <string>

#include "tests/timing/case_maker.h"
#include "tests/timing/case_runner.h"
#include "tests/timing/histogram.h"

namespace pipewright::timing {
namespace {

using WallClock = std::chrono::steady_clock;

constexpr int kDraws = 12;      ///< cases drawn for a restart, of which the best goes on
constexpr int kPatience = 150;  ///< changes in a row that make nothing better, then a restart

struct Options {
  std::uint64_t seed = 1;
  double minutes = 2;
  long evaluations = 0;
  std::string seek;
  std::string out = "worst";
  std::string start;
  std::string replay;
  double rate_hz = 100;
  double alpha = CycleCase{}.alpha;
  bool joint_risk = false;
  double clearance_m = -kInfinity;
};

/// Least distance of the robot's surface to anything, as estimated; negative: it is in something.
double Clearance(const ControlStats& stats) {
  const Clearances& c = stats.clearance;
  return std::min({c.plane_m, c.pipe_m, c.self_m, c.obstacle_m});
}

/// What a cycle costs in the measure that is sought.
double Cost(const std::string& seek, const CycleCost& c) {
  const ChanceQpStats& qp = c.stats.qp;
  if (seek == "instructions") {
    return static_cast<double>(c.instructions);
  }
  if (seek == "rest") {
    return static_cast<double>(c.instructions - c.in_solver);
  }
  if (seek == "iterations") {
    return c.iterations_max + 1e-3 * qp.iterations;
  }
  if (seek == "rounds") {
    return qp.rounds + 1e-3 * qp.iterations;
  }
  // Fitted by eye to what was counted: rows to be made, then per QP and iteration the active set.
  return 8000.0 * c.stats.rows + 150000.0 * c.stats.qp.rounds + c.work;
}

void Save(const CycleCase& c, const std::string& path) {
  std::ofstream file(path);
  Write(c, file);
  if (!file.flush()) {
    fmt::print(stderr, "worst_cycle: cannot write {}\n", path);
  }
}

class Search {
 public:
  Search(const Options& options, const CycleCase& start, const InstructionCount& instructions)
      : options_(options), start_(start), runner_(instructions), maker_(options.seed) {
    law_.period_s = 1 / options.rate_hz;
    law_.alpha = options.alpha;
    law_.joint_risk = options.joint_risk;
  }

  void Run() {
    const std::chrono::duration<double, std::ratio<60>> long_as(options_.minutes);
    end_ = WallClock::now() + std::chrono::duration_cast<WallClock::duration>(long_as);
    while (!Done()) {
      const bool given = restarts_++ == 0 && !start_.steps.empty();
      CycleCase here = given ? start_ : maker_.Draw(law_);
      double cost = Evaluate(here);
      for (int i = given ? kDraws : 1; i < kDraws && !Done(); ++i) {
        Take(maker_.Draw(law_), here, cost);
      }
      for (int idle = 0; idle < kPatience && !Done();) {
        const double before = cost;
        Take(maker_.Mutate(here), here, cost);
        idle = cost > before ? 0 : idle + 1;
      }
    }
  }

  void Print() const {
    const auto row = [](const char* name, auto value) { fmt::print("{:<28} {}\n", name, value); };
    row("sought", options_.seek);
    row("evaluations", evaluations_);
    row("restarts", restarts_);
    row("cycles", cycles_);
    row("worst instructions", worst_.instructions);
    row("worst in the solver", worst_.in_solver);
    row("worst rows", worst_.stats.rows);
    row("worst rounds", worst_.stats.qp.rounds);
    row("worst iterations", worst_.stats.qp.iterations);
    row("worst iterations of a QP", worst_.iterations_max);
    of_qps_.Print("iterations of a QP");
    of_cycles_.Print("iterations of a cycle");
    rounds_.Print("rounds of a cycle");
    active_.Print("active in a QP");
    row("worst case kept in", options_.out + ".case");
    for (const auto& [what, count] : troubles_) {
      fmt::print("trouble {:<20} {} cycles, first in {}.{}.case\n", what, count, options_.out,
                 what);
    }
  }

  bool found_trouble() const { return !troubles_.empty(); }

 private:
  bool Done() const {
    return options_.evaluations > 0 ? evaluations_ >= options_.evaluations
                                    : WallClock::now() >= end_;
  }

  void Take(const CycleCase& other, CycleCase& here, double& cost) {
    const double other_cost = Evaluate(other);
    if (other_cost >= cost) {
      here = other;
      cost = other_cost;
    }
  }

  double Evaluate(const CycleCase& c) {
    ++evaluations_;
    double cost = -kInfinity;
    for (const CycleCost& cycle : runner_.Run(c)) {
      const double clearance_m = Clearance(cycle.stats);
      if (clearance_m < options_.clearance_m) {
        cost = std::max(cost, clearance_m);  // less than any cycle's that counts: a way to one
        continue;
      }
      ++cycles_;
      cost = std::max(cost, Cost(options_.seek, cycle));
      rounds_.Add(cycle.stats.qp.rounds);
      of_cycles_.Add(cycle.stats.qp.iterations);
      for (const QpSpy::Solve& solve : cycle.solves) {
        of_qps_.Add(solve.iterations);
        active_.Add(std::max(solve.active, 0));
      }
      if (!cycle.trouble.empty() && ++troubles_[cycle.trouble] == 1) {
        Save(c, options_.out + "." + cycle.trouble + ".case");
      }
      if (Cost(options_.seek, cycle) > worst_cost_) {
        worst_cost_ = Cost(options_.seek, cycle);
        worst_ = cycle;
        Save(c, options_.out + ".case");
      }
    }
    if (WallClock::now() > next_report_) {
      next_report_ = WallClock::now() + std::chrono::seconds(10);
      fmt::print(stderr, "{} evaluations, {} restarts, most {} {:.0f}\n", evaluations_, restarts_,
                 options_.seek, worst_cost_);
    }
    return cost;
  }

  const Options& options_;
  CycleCase start_;  ///< to begin with; without a step: none
  CaseRunner runner_;
  CaseMaker maker_;
  CycleCase law_;
  long evaluations_ = 0;
  long restarts_ = 0;
  long cycles_ = 0;
  CycleCost worst_;
  double worst_cost_ = -1;
  Histogram of_qps_;
  Histogram of_cycles_;
  Histogram rounds_;
  Histogram active_;  ///< rows and bounds at the end of a QP; 0 also when it was capped
  std::map<std::string, long> troubles_;
  WallClock::time_point end_;
  WallClock::time_point next_report_ = WallClock::now() + std::chrono::seconds(10);
};

bool Load(const std::string& path, CycleCase& c) {
  std::ifstream file(path);
  std::string error = "it cannot be opened";
  if (!file || !Read(file, c, error)) {
    fmt::print(stderr, "worst_cycle: {}: {}\n", path, error);
    return false;
  }
  return true;
}

int Replay(const CycleCase& c, const InstructionCount& instructions) {
  CaseRunner runner(instructions);
  fmt::print("{:>5} {:>12} {:>12} {:>4} {:>6} {:>10} {:>6}  {}\n", "cycle", "instructions",
             "in solver", "rows", "rounds", "iterations", "one QP", "trouble");
  int number = 0;
  bool trouble = false;
  for (const CycleCost& cycle : runner.Run(c)) {
    fmt::print("{:>5} {:>12} {:>12} {:>4} {:>6} {:>10} {:>6}  {}\n", ++number, cycle.instructions,
               cycle.in_solver, cycle.stats.rows, cycle.stats.qp.rounds, cycle.stats.qp.iterations,
               cycle.iterations_max, cycle.trouble);
    trouble = trouble || !cycle.trouble.empty();
  }
  return trouble ? 1 : 0;
}

int Run(Options& options) {
  const InstructionCount instructions;
  if (!instructions.counting()) {
    fmt::print(stderr,
               "worst_cycle: nothing counts instructions; scripts/bench worst has QEMU "
               "count them\n");
  }
  CycleCase given;
  const std::string& path = options.replay.empty() ? options.start : options.replay;
  if (!path.empty() && !Load(path, given)) {
    return 2;
  }
  if (!options.replay.empty()) {
    return Replay(given, instructions);
  }
  if (options.seek.empty()) {
    options.seek = instructions.counting() ? "instructions" : "work";
  }
  const bool counted = options.seek == "instructions" || options.seek == "rest";
  if (counted && !instructions.counting()) {
    return 2;
  }
  Search search(options, given, instructions);
  search.Run();
  search.Print();
  return search.found_trouble() ? 1 : 0;
}

}  // namespace
}  // namespace pipewright::timing

int main(int argc, char** argv) {
  pipewright::timing::Options options;
  CLI::App app("Looks for the control cycle that takes the most instructions", "worst_cycle");
  app.add_option("--seed", options.seed, "of the search; with --evaluations it repeats exactly")
      ->capture_default_str();
  app.add_option("--minutes", options.minutes, "to search [min]")
      ->check(CLI::Range(0.0, 1e5))
      ->capture_default_str();
  app.add_option("--evaluations", options.evaluations, "instead, that many cases")
      ->check(CLI::Range(1L, 1000000000L));
  app.add_option("--seek", options.seek,
                 "instructions, or rest (those outside the QP solver), of a cycle; work by a "
                 "formula; iterations of one QP; rounds of a cycle")
      ->check(CLI::IsMember({"instructions", "rest", "work", "iterations", "rounds"}));
  app.add_option("--out", options.out, "the worst case goes to OUT.case, troubles to OUT.*.case")
      ->capture_default_str();
  app.add_option("--start", options.start, "a case to begin with");
  app.add_option("--replay", options.replay, "instead, runs a case and prints a line a cycle");
  app.add_option("--rate", options.rate_hz, "of the control law [Hz]")
      ->check(CLI::Range(50.0, 1000.0))
      ->capture_default_str();
  app.add_option("--alpha", options.alpha, "of the chance constraints")->capture_default_str();
  app.add_option("--clearance", options.clearance_m,
                 "only cycles in which the robot is estimated to be that far from everything [m]; "
                 "0: what can be, with surfaces that are where they are held to be");
  app.add_flag("--joint-risk", options.joint_risk, "alpha is of all rows together");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return pipewright::timing::Run(options);
}
