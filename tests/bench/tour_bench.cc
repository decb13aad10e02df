// SPDX-License-Identifier: MIT
// How far from the best the tours are that the solver finds in 10 and in 100 ms of one core, the
// reading of the costs and all else that a solve begins with included.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "plan/tour/tour_solver.h"
#include "platform/linux/clock.h"
#include "tests/plan/tour/tsplib_file.h"

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;
using test::TsplibInstance;

constexpr int kCapacity = 512;
constexpr std::int64_t kEndless = std::numeric_limits<std::int64_t>::max();
const char* const kKept[] = {"br17.atsp",    "ftv33.atsp",   "ft53.atsp", "ftv70.atsp",
                             "berlin52.tsp", "kro124p.atsp", "eil76.tsp", "kroA100.tsp"};

struct Options {
  std::vector<std::string> files;
  std::vector<double> budgets_ms = {10, 100};
  int seeds = 10;
  bool open = false;
  bool json = false;
};

struct Run {
  TourFigures figures;
  double took_ms = 0;
};

double Milliseconds(Duration d) { return ToSeconds(d) * 1e3; }

Run Solve(TourSolver& solver, const TourProblem& problem, const TourBudget& budget,
          std::uint64_t seed) {
  std::vector<TourNode> order(problem.n);
  const Time begin = Now();
  const auto figures = solver.Solve(problem, budget, seed, order);
  const Time end = Now();
  return {figures.ok() ? *figures : TourFigures{}, Milliseconds(end - begin)};
}

/// Over all seeds, of one instance and budget.
struct Row {
  double budget_ms = 0;
  std::vector<double> costs = {};
  std::vector<double> best_ms = {};  // until the tour was found, by running up to there again
  double took_ms_max = 0;
  double trials = 0;
  double took_ms = 0;
};

Row Measure(TourSolver& solver, const TourProblem& problem, double budget_ms, int seeds) {
  Row row{.budget_ms = budget_ms};
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto s = static_cast<std::uint64_t>(seed);
    const Time deadline = Now() + FromSeconds(budget_ms * 1e-3);
    const Run run = Solve(solver, problem, {kEndless, &Now, deadline}, s);
    const Run again = Solve(solver, problem, {.trials = run.figures.best_trial}, s);
    row.costs.push_back(run.figures.cost);
    row.best_ms.push_back(again.took_ms);
    row.took_ms_max = std::max(row.took_ms_max, run.took_ms);
    row.took_ms += run.took_ms;
    row.trials += static_cast<double>(run.figures.trials);
  }
  return row;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) {
    sum += v;
  }
  return sum / static_cast<double>(values.size());
}

double Max(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

void Report(const TsplibInstance& instance, double reference, bool proven, const Row& row,
            const Options& options, Json& object) {
  const auto gap = [&](double cost) {
    return reference > 0 ? 100 * (cost / reference - 1) : cost - reference;
  };
  const double gap_mean = gap(Mean(row.costs));
  const double gap_max = gap(Max(row.costs));
  const auto best = std::count(row.costs.begin(), row.costs.end(), reference);
  if (!options.json) {
    fmt::print(
        "{:<12}{:>4}{:>7.0f}{:>11.1f}{}{:>9.3f}{:>9.3f}{:>5d}/"
        "{:<3d}{:>9.1f}{:>9.1f}{:>10.2f}{:>9.2f}\n",
        instance.name, instance.n, row.budget_ms, reference, proven ? ' ' : '*', gap_mean, gap_max,
        best, row.costs.size(), row.trials / row.took_ms, Mean(row.best_ms), Max(row.best_ms),
        row.took_ms_max);
    return;
  }
  object["rows"].push_back({{"instance", instance.name},
                            {"n", instance.n},
                            {"budget_ms", row.budget_ms},
                            {"reference", reference},
                            {"reference_is_proven", proven},
                            {"gap_percent_mean", gap_mean},
                            {"gap_percent_max", gap_max},
                            {"at_reference", best},
                            {"seeds", row.costs.size()},
                            {"trials_per_s", 1e3 * row.trials / row.took_ms},
                            {"best_ms_mean", Mean(row.best_ms)},
                            {"best_ms_max", Max(row.best_ms)},
                            {"took_ms_max", row.took_ms_max}});
}

int Main(const Options& options) {
  TourSolver solver(kCapacity);
  Json object{{"open", options.open},
              {"node_capacity", kCapacity},
              {"memory_bytes", solver.MemoryBytes()},
              {"rows", Json::array()}};
  if (!options.json) {
    fmt::print("{} tours, {} seeds, {} bytes for up to {} nodes\n",
               options.open ? "open" : "closed", options.seeds, solver.MemoryBytes(), kCapacity);
    fmt::print("{:<12}{:>4}{:>7}{:>12}{:>9}{:>9}{:>9}{:>9}{:>9}{:>10}{:>9}\n", "instance", "n",
               "ms", "best known", "mean %", "max %", "there", "tries/ms", "best ms", "max",
               "took max");
  }
  for (const std::string& file : options.files) {
    const test::TsplibResult read = test::ReadTsplibFile(file);
    if (!read.instance || read.instance->n > kCapacity) {
      fmt::print(stderr, "bench_tour: {}\n",
                 read.instance ? file + ": more than 512 nodes" : read.error);
      return 2;
    }
    TourProblem problem = read.instance->Problem();
    problem.open = options.open;
    if (const Status status = CheckTour(problem); status != Status::kOk) {
      fmt::print(stderr, "bench_tour: {}: {}\n", file, Name(status));
      return 2;
    }
    const auto optimum = options.open ? std::nullopt : test::TsplibOptimum(read.instance->name);
    std::vector<Row> rows;
    double least = std::numeric_limits<double>::infinity();
    for (const double budget_ms : options.budgets_ms) {
      rows.push_back(Measure(solver, problem, budget_ms, options.seeds));
      least =
          std::min(least, *std::min_element(rows.back().costs.begin(), rows.back().costs.end()));
    }
    for (const Row& row : rows) {
      Report(*read.instance, optimum.value_or(least), optimum.has_value(), row, options, object);
    }
  }
  if (options.json) {
    fmt::print("{}\n", object.dump());
  } else {
    fmt::print("* not known: the best of these runs\n");
  }
  return 0;
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  CLI::App app{"Gaps of tours from the best known, within a time."};
  pipewright::bench::Options options;
  app.add_option("FILE", options.files, "TSPLIB instances; none: those of tests/data/tsplib");
  app.add_option("--seeds", options.seeds, "runs of each instance and time, from seed 1 on")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--ms", options.budgets_ms, "times for one solve")
      ->check(CLI::Range(0.01, 1e6))
      ->capture_default_str();
  app.add_flag("--open", options.open, "paths between any two nodes instead of closed tours");
  app.add_flag("--json", options.json, "one JSON object on stdout");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  if (options.files.empty()) {
    for (const char* const name : pipewright::bench::kKept) {
      options.files.push_back(std::string(PIPEWRIGHT_TEST_DATA "/tsplib/") + name);
    }
  }
  return pipewright::bench::Main(options);
}
