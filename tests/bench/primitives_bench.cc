// SPDX-License-Identifier: MIT
// Whether planes and pipes are as far off as their covariances say, over simulated depth frames,
// and what a frame costs from depth image to primitives.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hil/cli/heap_watch.h"
#include "tests/bench/primitives_frames.h"
#include "tests/support/chi_square.h"

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;
using test::Banded;
using test::Calibration;

// Disparity noise of 0.08 px and a baseline of 95 mm: σ(z) at 1 m = 0.08 / (f 0.095), z_min =
// f 0.095 / 126.
constexpr FrameCase kCases[] = {
    {"424x240, by 2", {}, 2, 0.8, 2.0, 0.25, 1.0},
    {"640x480",
     {.width = 640,
      .height = 480,
      .hfov_deg = 79.6,
      .z_min_m = 0.289,
      .noise_sigma_at_1m = 2.19e-3},
     4,
     0.8,
     2.4,
     0.3,
     1.2},
    {"848x480",
     {.width = 848, .height = 480, .hfov_deg = 87, .z_min_m = 0.337, .noise_sigma_at_1m = 1.89e-3},
     4,
     0.8,
     2.4,
     0.35,
     1.2},
    {"320x240, noisy",
     {.width = 320, .height = 240, .hfov_deg = 60, .z_min_m = 0.2, .noise_sigma_at_1m = 7e-3},
     2,
     0.8,
     1.6,
     0.25,
     0.8},
    {"424x240, quiet",
     {.width = 424, .height = 240, .hfov_deg = 70, .z_min_m = 0.15, .noise_sigma_at_1m = 1.0e-3},
     2,
     0.8,
     1.6,
     0.3,
     0.9},
};
constexpr const FrameCase& kTimed = kCases[1];

struct Options {
  int frames = 12000;
  int timed = 300;
  int passes = 3;
  std::uint64_t seed = 1;
  bool json = false;
};

Json ToJson(const Banded& b) {
  return {{"value", b.value}, {"lo99", b.lo}, {"hi99", b.hi}, {"within", b.within()}};
}

Json ToJson(const Calibration& c) {
  return {{"dof", c.dof},         {"count", c.count},     {"mean", ToJson(c.mean)},
          {"p50", ToJson(c.p50)}, {"p90", ToJson(c.p90)}, {"p99", ToJson(c.p99)},
          {"within", c.within()}};
}

std::string Line(const Banded& b) {
  return fmt::format(" {:6.3f} [{:6.3f} {:6.3f}]{}", b.value, b.lo, b.hi, b.within() ? ' ' : '!');
}

/// One case's figures, printed or into the object.
void Report(const std::string& name, const FrameErrors& errors, const Options& options,
            Json& object) {
  const struct {
    const char* name;
    const std::vector<double>& nees;
    int dof;
  } kinds[] = {{"plane (n, d)", errors.plane, 3},
               {"pipe axis", errors.axis, 4},
               {"pipe radius", errors.radius, 1},
               {"pipe, all", errors.pipe, 5}};
  Json of_case{{"case", name},
               {"frames", errors.frames},
               {"wrong_planes", errors.wrong_planes},
               {"wrong_pipes", errors.wrong_pipes}};
  if (!options.json) {
    fmt::print("{}: {} frames, {} planes and {} pipes where there are none\n", name, errors.frames,
               errors.wrong_planes, errors.wrong_pipes);
  }
  for (const auto& kind : kinds) {
    const Calibration c = test::Calibrate(kind.nees, kind.dof);
    of_case["calibration"][kind.name] = ToJson(c);
    if (!options.json) {
      fmt::print("  {:<13}{:6d}{}{}{}{}\n", kind.name, c.count, Line(c.mean), Line(c.p50),
                 Line(c.p90), Line(c.p99));
    }
  }
  object["cases"].push_back(of_case);
}

double Quantile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  return values.empty()
             ? 0
             : values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

void ReportTimes(const Options& options, Json& object) {
  const FrameTimes times = MeasureTimes(kTimed, options.timed, options.passes, options.seed + 99);
  const struct {
    const char* name;
    const std::vector<double>& ms;
  } parts[] = {{"cloud", times.cloud_ms}, {"view", times.view_ms}, {"planes", times.planes_ms},
               {"pipes", times.pipes_ms}, {"all", times.all_ms},   {"clusters", times.clusters_ms}};
  const auto n = static_cast<double>(std::max<std::size_t>(1, times.all_ms.size()));
  Json json{{"case", kTimed.name},
            {"frames", times.all_ms.size()},
            {"passes", options.passes},
            {"planes_a_frame", times.planes / n},
            {"pipes_a_frame", times.pipes / n},
            {"clusters_a_frame", times.clusters / n},
            {"heap_counted", hil::HeapWatch::Counting()},
            {"heap_allocations", times.heap_allocations}};
  if (!options.json) {
    fmt::print(
        "{}, {} frames, least of {} passes: {:.2f} planes, {:.2f} pipes and {:.2f} clusters a "
        "frame, heap allocations {}\n  ms           p50     p99     max\n",
        kTimed.name, times.all_ms.size(), options.passes, times.planes / n, times.pipes / n,
        times.clusters / n,
        hil::HeapWatch::Counting() ? std::to_string(times.heap_allocations) : "not counted");
  }
  for (const auto& part : parts) {
    const double p50 = Quantile(part.ms, 0.5);
    const double p99 = Quantile(part.ms, 0.99);
    const double max = Quantile(part.ms, 1);
    json["ms"][part.name] = {{"p50", p50}, {"p99", p99}, {"max", max}};
    if (!options.json) {
      fmt::print("  {:<8}{:8.2f}{:8.2f}{:8.2f}\n", part.name, p50, p99, max);
    }
  }
  object["time"] = json;
}

int Run(const Options& options) {
  Json object;
  if (options.frames > 0) {
    if (!options.json) {
      fmt::print(
          "normalised errors squared [two-sided 99 % band], ! outside\n  {:<13}{:>6}{:>24}"
          "{:>24}{:>24}{:>24}\n",
          "", "count", "mean", "p50", "p90", "p99");
    }
    FrameErrors all;
    const int cases = static_cast<int>(std::size(kCases));
    for (int k = 0; k < cases; ++k) {
      const FrameErrors errors =
          MeasureErrors(kCases[k], options.frames / cases, options.seed + static_cast<unsigned>(k));
      Report(kCases[k].name, errors, options, object);
      all += errors;
    }
    Report("all", all, options, object);
  }
  if (options.timed > 0) {
    ReportTimes(options, object);
  }
  if (options.json) {
    fmt::print("{}\n", object.dump());
  }
  return 0;
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  CLI::App app{"Errors of planes and pipes against their covariances, and what a frame costs."};
  pipewright::bench::Options options;
  app.add_option("--frames", options.frames, "simulated frames, over all cases; 0: none")
      ->check(CLI::Range(0, 10000000))
      ->capture_default_str();
  app.add_option("--timed", options.timed, "frames that are timed; 0: none")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  app.add_option("--passes", options.passes, "runs of each timed frame; the least counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of rooms, poses and noise")->capture_default_str();
  app.add_flag("--json", options.json, "one JSON object on stdout");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return pipewright::bench::Run(options);
}
