// SPDX-License-Identifier: MIT
// pipewright: the desk's side of the robot. `pipewright --help` tells the rest.

#include <fmt/format.h>

#include "hil/cli/canlog_command.h"
#include "hil/cli/emulate_command.h"
#include "hil/cli/gateway_command.h"
#include "hil/cli/inspect_command.h"
#include "hil/cli/map_command.h"
#include "hil/cli/memory_command.h"
#include "hil/cli/primitives_command.h"
#include "hil/cli/qp_command.h"
#include "hil/cli/replay_command.h"
#include "hil/cli/service_command.h"

namespace {

/// CLI11 only says that a command is missing; a person wants to know which word it did not know.
bool KnowsCommand(const CLI::App& app, const std::string& word) {
  std::string known;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (word.starts_with('-') || command->get_name() == word) {
      return true;
    }
    known += " " + command->get_name();
  }
  fmt::print(stderr, "pipewright: no command '{}'; there are:{}\n", word, known);
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Pipewright: inspection of places no person should enter, by a mobile manipulator."};
  app.require_subcommand(1);
  app.set_version_flag("--version", PIPEWRIGHT_VERSION);
  int exit_code = 0;
  pipewright::hil::AddCanlog(app, &exit_code);
  pipewright::hil::AddEmulate(app, &exit_code);
  pipewright::hil::AddGateway(app, &exit_code);
  pipewright::hil::AddInspect(app, &exit_code);
  pipewright::hil::AddMap(app, &exit_code);
  pipewright::hil::AddMemory(app, &exit_code);
  pipewright::hil::AddPrimitives(app, &exit_code);
  pipewright::hil::AddQp(app, &exit_code);
  pipewright::hil::AddReplay(app, &exit_code);
  pipewright::hil::AddService(app, &exit_code);
  if (argc > 1 && !KnowsCommand(app, argv[1])) {
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return exit_code;
}
