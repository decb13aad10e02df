// SPDX-License-Identifier: MIT
// The map beside liboctomap: the same scans, rays and views in one run, pass by pass in turn, and
// the least time of every scan and view. Both must come to the same sums. Only ratios of one run
// travel.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "perception/map/distance_field.h"
#include "tests/bench/map_rivals.h"

namespace pipewright::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

/// The least time of each part of some work, in seconds, over all passes: what else the machine
/// does disturbs a part, not the sum.
class Stopwatch {
 public:
  template <typename Work>
  void Time(std::size_t part, Work work) {
    const Clock::time_point begin = Clock::now();
    work();
    const double took_s = std::chrono::duration<double>(Clock::now() - begin).count();
    least_s_.resize(std::max(least_s_.size(), part + 1), 1e30);
    least_s_[part] = std::min(least_s_[part], took_s);
  }
  double least_s() const { return std::accumulate(least_s_.begin(), least_s_.end(), 0.0); }

 private:
  std::vector<double> least_s_;
};

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

/// Of a cell of 40 x 40 x 40 voxels: ms a rebuild, after one voxel changed; nobody to compare with.
double FieldUpdate_ms(MapScene scene, int passes) {
  scene.config.lo = {-5, -5, -5};
  scene.config.hi = {34, 34, 34};
  scene.config.brick_capacity = BricksOfBox(scene.config);
  VoxelGrid grid(scene.config);
  for (const test::Scan& scan : scene.scans) {
    test::InsertOurs(&grid, scan);
  }
  DistanceField field(grid.config());
  Stopwatch watch;
  for (int pass = 0; pass < 10 * passes; ++pass) {
    grid.Restore({34, 34, 34}, pass % 2 == 0 ? 1.0F : -1.0F);
    watch.Time(0, [&] { field.Update(grid); });
  }
  return 1e3 * watch.least_s();
}

Json ToJson(const std::vector<Comparison>& all, double field_ms) {
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
          {"field_update_ms", field_ms}};
}

void Print(const std::vector<Comparison>& all, double field_ms) {
  fmt::print("{:<32} {:>10} {:>10} {:>10}  {:>6}  {:>6}\n", "work", "unit", "ours", "OctoMap",
             "ratio", "target");
  for (const Comparison& c : all) {
    fmt::print("{:<32} {:>10} {:>10.3f} {:>10.3f}  {:>5.1f}x  {:>5.0f}x{}\n", c.work, c.unit,
               c.ours.least_s() * c.per_s, c.octomap.least_s() * c.per_s, c.ratio(), c.target,
               c.agree ? "" : "  SUMS DIFFER");
  }
  fmt::print(
      "a voxel of an allocated brick takes {} bytes; a distance field of 40 x 40 x 40 voxels "
      "is updated in {:.3f} ms\n",
      VoxelGrid::kBytesPerVoxel, field_ms);
}

int Run(int passes, const std::string& only, bool json) {
  std::vector<Comparison> all;
  std::optional<double> field_ms;
  for (const MapScene& scene : MapScenes()) {
    field_ms = field_ms ? field_ms : FieldUpdate_ms(scene, passes);
    if (only.empty() || scene.name == only) {
      CompareInsertion(scene, passes, &all);
      CompareQuestions(scene, passes, &all);
    }
  }
  if (json) {
    fmt::print("{}\n", ToJson(all, *field_ms).dump());
  } else {
    Print(all, *field_ms);
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
