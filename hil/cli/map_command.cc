// SPDX-License-Identifier: MIT
#include "hil/cli/map_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "hil/cli/map_figures.h"
#include "hil/cli/map_files.h"
#include "hil/cli/map_run.h"

namespace pipewright::hil {
namespace {

constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;

int Fail(int exit_code, const std::string& why) {
  fmt::print(stderr, "pipewright: {}\n", why);
  return exit_code;
}

/// @returns an error in words, or nothing
template <typename Content>
std::string Take(FileResult<Content> read, Content& to) {
  if (read.content) {
    to = std::move(*read.content);
  }
  return read.error;
}

std::string ReadInput(const MapOptions& options, MapInput& input) {
  std::string error = Take(ReadScans(options.file), input.scans);
  if (error.empty() && !options.rays.empty()) {
    error = Take(ReadRays(options.rays), input.rays);
  }
  if (error.empty() && !options.views.empty()) {
    error = Take(ReadViews(options.views), input.views);
  }
  return error;
}

std::string WriteResults(const MapOptions& options, const MapRun& run) {
  std::string error = options.dump.empty() ? "" : WriteMapDump(run, options.dump);
  if (error.empty() && !options.hits.empty()) {
    error = WriteRayHits(run, options.hits);
  }
  if (error.empty() && !options.gains.empty()) {
    error = WriteViewCounts(run, options.gains);
  }
  return error;
}

int Map(const MapOptions& options) {
  MapInput input;
  if (const std::string error = ReadInput(options, input); !error.empty()) {
    return Fail(kBadInput, error);
  }
  const MapRun run = RunMap(input, options);
  if (!run.error.empty()) {
    return Fail(kBadInput, fmt::format("{}: {}", options.file, run.error));
  }
  if (const std::string error = WriteResults(options, run); !error.empty()) {
    return Fail(kFailed, error);
  }
  const nlohmann::ordered_json figures = MapJson(input, run, options);
  constexpr auto kAnyBytes = nlohmann::ordered_json::error_handler_t::replace;  // in a file's name
  const std::string text =
      options.json ? figures.dump(-1, ' ', false, kAnyBytes) + "\n" : MapTable(figures);
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    return Fail(kFailed, "standard output took no more");
  }
  return run.stats.refused == 0 ? kOk : kFailed;
}

}  // namespace

void AddMap(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "map", "Build a map of the scans of a file, time it, and ask it rays and views");
  const auto options = std::make_shared<MapOptions>();
  command
      ->add_option("FILE", options->file,
                   "scans in MPC1; hil/scans/scan_file.h describes all three formats")
      ->required();
  CLI::Option* rays =
      command->add_option("--rays", options->rays, "cast the rays of this file, in MPR1");
  CLI::Option* views = command->add_option(
      "--views", options->views, "evaluate the views of this file, in MPV1, as a planner's gain");
  CLI::Option* box =
      command
          ->add_option("--box", options->box,
                       "store the voxels from x y z to x y z, inclusive, and no others;\n"
                       "without it, all that the scans can touch")
          ->expected(6);
  command
      ->add_option(
          "--window", options->window_m,
          "store a box with sides of so many m, in whole bricks, which follows the scans'\n"
          "origins. Bricks that leave it are kept aside, taken in again when it comes back,\n"
          "and are in the --dump; rays and views see the box where it ends")
      ->check(CLI::Range(0.1, 1000.0))
      ->excludes(box);
  command->add_flag("--discretise", options->discretise,
                    "one ray for each voxel that holds points, instead of one for each point");
  command
      ->add_option("--repeat", options->repeat,
                   "passes, each from an empty map; a time is its least of all passes")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_option("--dump", options->dump,
                      "write every known voxel and its log-odds to this file, in MPM1");
  command->add_option("--hits", options->hits, "write where the rays ended to this file, in MPH1")
      ->needs(rays);
  command->add_option("--gains", options->gains, "write what the views count to this file, in MPG1")
      ->needs(views);
  command->add_flag("--json", options->json, "print one object, and nothing else, on stdout");
  command->callback([options, exit_code] { *exit_code = Map(*options); });
  command->footer(
      "Scans enter as OctoMap 1.9.7's insertPointCloud takes them, with its sensor model: every\n"
      "voxel has OctoMap's state and log-odds. Rays end where its castRay ends them. A view "
      "counts\n"
      "unknown voxels along its visual rays and surfaces at the ends of its coverage rays; which\n"
      "voxels are covered is given by a hash of their key, as in the reference of such sets.\n"
      "Exit code: 0 done; 1 the map had no room for something, or a result could not be written;\n"
      "2 the input is bad.\n"
      "Example: pipewright map cube_clouds.bin --dump cube_map.bin --repeat 10");
}

}  // namespace pipewright::hil
