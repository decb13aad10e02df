// SPDX-License-Identifier: MIT
// The map beside liboctomap: the same scans, rays and views in one run, pass by pass in turn, and
// the least time of every scan and view. Both must come to the same sums. Only ratios of one run
// travel.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "tests/bench/map_field.h"
#include "tests/bench/map_gain.h"
#include "tests/bench/map_rivals.h"
#include "tests/bench/stopwatch.h"

namespace pipewright::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Comparison {
  std::string work;
  std::string unit;
  double per_s = 1;  ///< units a second, of one pass over all the work
  double target = 0;
  Stopwatch ours;
  Stopwatch octomap;
  bool agree = true;

  double ratio() const { return octomap.least_s() / ours.least_s(); }
};

Comparison Compared(const MapScene& scene, const char* work, const char* unit, double per_s,
                    double cube, double office) {
  Comparison c;
  c.work = scene.name + ", " + work;
  c.unit = unit;
  c.per_s = per_s;
  c.target = scene.name == "office" ? office : cube;
  return c;
}

void CompareInsertion(const MapScene& scene, int passes, std::vector<Comparison>* all) {
  for (const bool discretize : {false, true}) {
    const double per_s = 1e3 / static_cast<double>(scene.scans.size());
    Comparison c = discretize ? Compared(scene, "insertion, discretised", "ms a scan", per_s, 6, 20)
                              : Compared(scene, "insertion, exact", "ms a scan", per_s, 4, 15);
    for (int pass = 0; pass < passes; ++pass) {  // each from an empty map
      OurMap ours(scene);
      OctomapMap theirs(scene);
      for (std::size_t scan = 0; scan < scene.scans.size(); ++scan) {
        c.ours.Time(scan, [&] { ours.Insert(scan, discretize); });
      }
      for (std::size_t scan = 0; scan < scene.scans.size(); ++scan) {
        c.octomap.Time(scan, [&] { theirs.Insert(scan, discretize); });
      }
      c.agree = c.agree && (pass > 0 || ours.Known() == theirs.Known());
    }
    all->push_back(c);
  }
}

/// One pass over all views. Either map has the machine for itself that long, caches included.
template <typename Ask>
Checksum TimeViews(const MapScene& scene, Stopwatch* watch, Ask ask) {
  Checksum sum{};
  for (std::size_t view = 0; view < scene.views.size(); ++view) {
    Checksum one;
    watch->Time(view, [&] { one = ask(view); });
    std::transform(sum.begin(), sum.end(), one.begin(), sum.begin(), std::plus<>());
  }
  return sum;
}

void CompareQuestions(const MapScene& scene, int passes, std::vector<Comparison>* all) {
  OurMap ours(scene);
  OctomapMap theirs(scene);
  for (std::size_t scan = 0; scan < scene.scans.size(); ++scan) {
    ours.Insert(scan, false);
    theirs.Insert(scan, false);
  }
  const auto rays = static_cast<double>(scene.views.size() * scene.views.front().visual_W.size());
  Comparison cast = Compared(scene, "castRay", "ns a ray", 1e9 / rays, 8, 10);
  Comparison gain = Compared(scene, "CFNBV views", "us a view",
                             1e6 / static_cast<double>(scene.views.size()), 12, 12);
  for (int pass = 0; pass < passes; ++pass) {
    cast.agree &= TimeViews(scene, &cast.ours, [&](auto view) { return ours.CastRays(view); }) ==
                  TimeViews(scene, &cast.octomap, [&](auto view) { return theirs.CastRays(view); });
    gain.agree &= TimeViews(scene, &gain.ours, [&](auto view) { return ours.Evaluate(view); }) ==
                  TimeViews(scene, &gain.octomap, [&](auto view) { return theirs.Evaluate(view); });
  }
  all->push_back(cast);
  all->push_back(gain);
}

Json ToJson(const std::vector<Comparison>& all, const FieldTimes& field, double gain_us) {
  Json rows = Json::array();
  for (const Comparison& c : all) {
    rows.push_back({{"work", c.work},
                    {"unit", c.unit},
                    {"ours", c.ours.least_s() * c.per_s},
                    {"octomap", c.octomap.least_s() * c.per_s},
                    {"ratio", c.ratio()},
                    {"target", c.target},
                    {"agree", c.agree}});
  }
  return {{"comparisons", rows},
          {"bytes_per_voxel", VoxelGrid::kBytesPerVoxel},
          {"field_update_ms",
           {{"one_voxel", field.one_voxel_ms},
            {"one_scan", field.one_scan_ms},
            {"all_cells", field.all_cells_ms}}},
          {"gain_us_a_view", gain_us}};
}

void Print(const std::vector<Comparison>& all, const FieldTimes& field, double gain_us) {
  fmt::print("{:<32} {:>10} {:>10} {:>10}  {:>6}  {:>6}\n", "work", "unit", "ours", "OctoMap",
             "ratio", "target");
  for (const Comparison& c : all) {
    fmt::print("{:<32} {:>10} {:>10.3f} {:>10.3f}  {:>5.1f}x  {:>5.0f}x{}\n", c.work, c.unit,
               c.ours.least_s() * c.per_s, c.octomap.least_s() * c.per_s, c.ratio(), c.target,
               c.agree ? "" : "  SUMS DIFFER");
  }
  fmt::print(
      "a voxel of an allocated brick takes {} bytes\n"
      "a distance field of 40 x 40 x 40 voxels is updated in {:.4f} ms after one voxel, {:.3f} ms "
      "after a scan, {:.3f} ms anew\n"
      "the gain of a view of the planner, 200 + 200 rays, is told in {:.1f} us\n",
      VoxelGrid::kBytesPerVoxel, field.one_voxel_ms, field.one_scan_ms, field.all_cells_ms,
      gain_us);
}

int Run(int passes, const std::string& only, bool json) {
  std::vector<Comparison> all;
  std::optional<FieldTimes> field;  // this and the gain: of the first scene
  double gain_us = 0;
  for (const MapScene& scene : MapScenes()) {
    if (!field) {
      field = TimeField(scene, passes);
      gain_us = TimeGain(scene, passes);
    }
    if (only.empty() || scene.name == only) {
      CompareInsertion(scene, passes, &all);
      CompareQuestions(scene, passes, &all);
    }
  }
  if (json) {
    fmt::print("{}\n", ToJson(all, *field, gain_us).dump());
  } else {
    Print(all, *field, gain_us);
  }
  const bool agree = std::all_of(all.begin(), all.end(), [](const auto& c) { return c.agree; });
  return agree && !all.empty() ? 0 : 1;
}

}  // namespace
}  // namespace pipewright::bench

int main(int argc, char** argv) {
  CLI::App app{
      "The map beside liboctomap in one run. With PIPEWRIGHT_SHARED set, on the cube and the "
      "office\n"
      "of its data/map; else on a made-up cube. Exit code 1: the two maps came to other sums."};
  int passes = 5;
  std::string only;
  bool json = false;
  app.add_option("--passes", passes, "a time is its least of all passes")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--scene", only, "this one only");
  app.add_flag("--json", json, "print one object, and nothing else, on stdout");
  CLI11_PARSE(app, argc, argv);
  return pipewright::bench::Run(passes, only, json);
}
