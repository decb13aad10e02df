// SPDX-License-Identifier: MIT
#include "hil/cli/primitives_command.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include "hil/cli/primitives_run.h"

namespace pipewright::hil {
namespace {

constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;

int Primitives(const PrimitivesOptions& options) {
  const PcdResult read = ReadPcd(options.file);
  if (!read.cloud) {
    fmt::print(stderr, "pipewright: {}\n", read.error);
    return kBadInput;
  }
  // CLI11's ranges let NaN pass.
  const std::pair<const char*, double> numbers[] = {
      {"--sigma", options.sigma_m},           {"--neighbour", options.neighbour_m},
      {"--range", options.range_m},           {"--radius-min", options.radius_min_m},
      {"--radius-max", options.radius_max_m}, {"--length-min", options.length_min_m},
      {"--reach", options.reach_m},           {"--spacing", options.spacing_rad.value_or(0)}};
  for (const auto& [name, value] : numbers) {
    if (std::isnan(value)) {
      fmt::print(stderr, "pipewright: {} is not a number\n", name);
      return kBadInput;
    }
  }
  if (options.radius_min_m >= options.radius_max_m) {
    fmt::print(stderr, "pipewright: --radius-min is not below --radius-max\n");
    return kBadInput;
  }
  const PrimitivesRun run = RunPrimitives(*read.cloud, options);
  // A file's name may be any bytes; JSON takes UTF-8 only.
  const std::string text =
      options.json
          ? PrimitivesJson(run, options)
                    .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
                "\n"
          : PrimitivesTable(run, options);
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    fmt::print(stderr, "pipewright: standard output took no more\n");
    return kFailed;
  }
  return kOk;
}

}  // namespace

void AddPrimitives(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "primitives",
      "Find planes and pipes in a point cloud, with how sure they are, and clusters of the rest");
  const auto options = std::make_shared<PrimitivesOptions>();
  command
      ->add_option("FILE", options->file,
                   "a PCD file: ascii, binary or binary_compressed, fields x y z")
      ->required();
  command
      ->add_option("--sigma", options->sigma_m,
                   "standard deviation of a reading [m]: of an image's depth at 1 m, growing with\n"
                   "its square (0.004 when not given); of an unorganised point in each direction\n"
                   "(0.01)")
      ->check(CLI::Range(1e-5, 1.0));
  command
      ->add_option("--neighbour", options->neighbour_m,
                   "unorganised points this near have a common normal [m]")
      ->check(CLI::Range(1e-3, 10.0))
      ->capture_default_str();
  command->add_option("--range", options->range_m, "farther readings of an image are not used [m]")
      ->check(CLI::Range(0.1, 100.0))
      ->capture_default_str();
  command->add_option("--radius-min", options->radius_min_m, "of pipes [m]")
      ->check(CLI::Range(1e-3, 10.0))
      ->capture_default_str();
  command->add_option("--radius-max", options->radius_max_m, "of pipes [m]")
      ->check(CLI::Range(1e-3, 10.0))
      ->capture_default_str();
  command->add_option("--length-min", options->length_min_m, "of pipes [m]")
      ->check(CLI::Range(1e-3, 100.0))
      ->capture_default_str();
  command
      ->add_option(
          "--reach", options->reach_m,
          "points that no plane and no pipe explains are of one cluster when they are this\n"
          "near [m]")
      ->check(CLI::Range(1e-3, 10.0))
      ->capture_default_str();
  command
      ->add_option(
          "--spacing", options->spacing_rad,
          "that reach is at least this, times the range from the frame's origin [rad]: of\n"
          "an image three pixels when not given, of unorganised points 0")
      ->check(CLI::Range(0.0, 0.5));
  command->add_option("--seed", options->seed, "of the draws")->capture_default_str();
  command->add_flag("--json", options->json, "print one object, and nothing else, on stdout");
  command->callback([options, exit_code] { *exit_code = Primitives(*options); });
  command->footer(
      "A file of more than one row that a pinhole at the origin could have seen is taken as its\n"
      "depth image, z forward; any other as points in any order. Printed, in the file's frame:\n"
      "planes n'x = d with the rectangle that was seen, pipes by a point p and the direction l of\n"
      "their axis and the radius, each with its standard deviations, the points it was fitted to\n"
      "and chi2 per degree of freedom: near 1 when --sigma is right; then clusters of at least 20\n"
      "points that none of them explains, by their centroid p and the sides of the box along the\n"
      "frame's axes that holds them. More than 32768 unexplained points are first thinned evenly\n"
      "in space, to one a cube of a quarter of the reach or wider. --json adds covariances, of\n"
      "(n, d) and of (p, l, r), and of clusters the box's corners and the spread along their own\n"
      "axes.\n"
      "Exit code: 0 the file was read, whatever was found; 2 the input is bad.\n"
      "Example: pipewright primitives scan.pcd --sigma 0.02");
}

}  // namespace pipewright::hil
