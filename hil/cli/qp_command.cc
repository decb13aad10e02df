// SPDX-License-Identifier: MIT
#include "hil/cli/qp_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "hil/cli/qp_run.h"
#include "hil/qpb/qpb.h"

namespace pipewright::hil {
namespace {

constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;

int Refuse(const std::string& why) {
  fmt::print(stderr, "pipewright: {}\n", why);
  return kBadInput;
}

/// A file's name may be any bytes; JSON takes UTF-8 only.
std::string Dump(const nlohmann::ordered_json& object) {
  return object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

int Qp(const QpOptions& options) {
  const QpbResult read = ReadQpb(options.file);
  if (!read.set) {
    return Refuse(read.error);
  }
  const QpRun run = RunQpSet(*read.set, options);
  if (!run.error.empty()) {
    return Refuse(fmt::format("{}: {}", options.file, run.error));
  }
  const std::string text =
      options.json ? Dump(QpJson(*read.set, run, options)) : QpTable(*read.set, run, options);
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    fmt::print(stderr, "pipewright: standard output took no more\n");
    return kFailed;
  }
  return Passed(run) ? kOk : kFailed;
}

}  // namespace

void AddQp(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "qp", "Solve the quadratic programs of a file with the controller's solver, and time it");
  const auto options = std::make_shared<QpOptions>();
  command
      ->add_option("FILE", options->file,
                   "a set of problems in QPB1; hil/qpb/qpb.h describes the format")
      ->required();
  command->add_flag("--warm", options->warm,
                    "start each problem from the active set of the one before, as a controller\n"
                    "does; without it every problem starts from none");
  command
      ->add_option("--repeat", options->repeat,
                   "passes over the set; a problem's time is its least of all passes, the\n"
                   "algorithm's and not the system's")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "print one object, and nothing else, on stdout");
  command->callback([options, exit_code] { *exit_code = Qp(*options); });
  command->footer(
      "Printed of each problem, counted from 0: status (optimal, infeasible, capped), iterations\n"
      "(rows added or dropped), relative KKT residual in the file's own numbers, least time; with\n"
      "--json also x in the file's variables, slacks included. Of the set: the spread of those\n"
      "times, and heap allocations. Timed and counted is the solve alone; every number of the\n"
      "problem is new to it. With --warm the spread is of the warm starts: the first problem, "
      "which\n"
      "has none before it, is timed in its own line only. Hard rows of one variable are posed as\n"
      "its bounds, slacks are not posed at all. At most 32 variables beside the slacks and 256\n"
      "rows.\n"
      "Exit code: 0 every problem ended as the file expects; 1 one did not, or its optimum has a\n"
      "KKT residual above 1e-6; 2 the input is bad.\n"
      "Example: pipewright qp tests/data/qp/drift.qpb --warm --repeat 20");
}

}  // namespace pipewright::hil
