// SPDX-License-Identifier: MIT
#include "hil/cli/memory_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "hil/cli/inspection.h"
#include "hil/cli/memory_figures.h"

namespace pipewright::hil {
namespace {

int Memory(const InspectionOptions& options) {
  const ScenarioResult loaded = LoadScenario(options.scenario);
  for (const std::string& error : loaded.errors) {
    fmt::print(stderr, "pipewright: {}\n", error);
  }
  if (!loaded.scenario || !loaded.errors.empty()) {
    return 2;
  }
  const RobotProgramConfig config = ProgramConfig(*loaded.scenario, options);
  const nlohmann::ordered_json figures =
      MemoryJson(loaded.scenario->name, config, MemoryParts(config));
  const std::string text = options.json ? figures.dump() + "\n" : MemoryTable(figures);
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    fmt::print(stderr, "pipewright: standard output took no more\n");
    return 1;
  }
  return 0;
}

}  // namespace

void AddMemory(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "memory", "Print the bytes that the robot's program takes at start, part by part");
  const auto options = std::make_shared<InspectionOptions>();
  command
      ->add_option("--scenario", options->scenario,
                   "pipes1, pipes2, pipes3, or a TOML file of your own: its map's box decides")
      ->capture_default_str();
  command->add_flag("--json", options->json, "print one object, and nothing else, on stdout");
  command->callback([options, exit_code] { *exit_code = Memory(*options); });
  command->footer(
      "Every capacity is fixed at start; after it no part takes anything more.\n"
      "Exit code: 0 done, 2 the input is bad.\n"
      "Example: pipewright memory --scenario pipes3");
}

}  // namespace pipewright::hil
