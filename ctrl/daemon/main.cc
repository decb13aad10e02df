// SPDX-License-Identifier: MIT
// pipewrightd: the robot program on the robot's computer. `pipewrightd --help` tells the rest.

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "ctrl/daemon/config.h"

namespace pipewright {
namespace {

constexpr int kOk = 0;
constexpr int kBadInput = 2;

struct Options {
  std::string config = "/etc/pipewright/pipewrightd.toml";
  bool check = false;
  bool print = false;
};

int Main(const Options& options) {
  const DaemonConfigResult loaded = LoadDaemonConfig(options.config);
  for (const std::string& error : loaded.errors) {
    fmt::print(stderr, "pipewrightd: {}\n", error);
  }
  if (!loaded.config) {
    return kBadInput;
  }
  if (options.print) {
    fmt::print("{}", DaemonConfigText(*loaded.config));
  }
  return kOk;
}

}  // namespace
}  // namespace pipewright

int main(int argc, char** argv) {
  CLI::App app{"pipewrightd: the robot program on the robot's computer, as a service."};
  app.set_version_flag("--version", PIPEWRIGHT_VERSION);
  pipewright::Options options;
  app.add_option("--config", options.config, "what the robot is and where it works, TOML")
      ->capture_default_str();
  app.add_flag("--check", options.check, "only say what is wrong with the configuration");
  app.add_flag("--print-config", options.print,
               "only print the configuration, every default written out");
  app.footer(
      "Talk to it with `pipewright status`, start, stop, estop and rearm.\n"
      "Exit code: 0 it was asked to end (SIGTERM, SIGINT), and the robot is at rest; 1 it could "
      "not\n"
      "run; 2 bad usage or configuration, every error as FILE:LINE:COLUMN: KEY: WHAT.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return pipewright::Main(options);
}
