// SPDX-License-Identifier: MIT
// pipewright: the desk's side of the robot. `pipewright --help` tells the rest.

#include "hil/cli/inspect_command.h"

int main(int argc, char** argv) {
  CLI::App app{"Pipewright: inspection of places no person should enter, by a mobile manipulator."};
  app.require_subcommand(1);
  app.set_version_flag("--version", PIPEWRIGHT_VERSION);
  int exit_code = 0;
  pipewright::hil::AddInspect(app, &exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return exit_code;
}
