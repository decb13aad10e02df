// SPDX-License-Identifier: MIT
#include "hil/cli/map_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "hil/cli/heap_watch.h"
#include "hil/cli/run_figures.h"

namespace pipewright::hil {
namespace {

using Json = nlohmann::ordered_json;

Json Rounded(double value) { return std::round(value * 1e3) / 1e3; }

Json Voxel(const VoxelIndex& v) { return Json::array({v.x, v.y, v.z}); }

Json RayJson(const RayAnswers& answers) {
  const auto hit = [](const RayHit& h) { return h.hit; };
  return {{"hits", std::count_if(answers.hits.begin(), answers.hits.end(), hit)},
          {"ns_per_ray", Rounded(answers.ns)}};
}

Json ViewJson(const MapRun& run) {
  std::uint64_t unknown = 0;
  std::uint64_t visual_hits = 0;
  std::uint64_t uncovered_hits = 0;
  std::uint64_t coverage_hits = 0;
  for (const ViewCounts& view : run.views) {
    unknown += view.unknown;
    visual_hits += view.visual_hits;
    uncovered_hits += view.uncovered_hits;
    coverage_hits += view.coverage_hits;
  }
  return {{"count", run.views.size()},      {"unknown", unknown},
          {"visual_hits", visual_hits},     {"uncovered_hits", uncovered_hits},
          {"coverage_hits", coverage_hits}, {"ms", Rounded(run.views_ms)}};
}

Json InsertionJson(const MapRun& run) {
  const double sum_ms = std::accumulate(run.insert_ms.begin(), run.insert_ms.end(), 0.0);
  return {{"points", run.stats.points},
          {"rejected", run.stats.rejected},
          {"hits", run.stats.hits},
          {"misses", run.stats.misses},
          {"refused", run.stats.refused},
          {"ms_per_scan",
           {{"mean", Rounded(sum_ms / static_cast<double>(run.insert_ms.size()))},
            {"p50", Rounded(Percentile(run.insert_ms, 0.5))},
            {"max", Rounded(Percentile(run.insert_ms, 1))}}}};
}

}  // namespace

Json MapJson(const MapInput& input, const MapRun& run, const MapOptions& options) {
  const VoxelGrid& grid = *run.grid;
  const MapCounts& counts = grid.counts();
  Json figures = {
      {"file", options.file},
      {"scans", input.scans.scans.size()},
      {"width_m", input.scans.width_m},
      {"max_range_m", input.scans.max_range_m},
      {"discretised", options.discretise},
      {"passes", options.repeat},
      {"insertion", InsertionJson(run)},
      {"map",
       {{"lo", Voxel(grid.config().lo)},
        {"hi", Voxel(grid.config().hi)},
        {"free", counts.free},
        {"occupied", counts.occupied},
        {"unknown", counts.unknown}}},
      {"memory",
       {{"bytes", grid.MemoryBytes()},
        {"bricks_used", grid.bricks_used()},
        {"bricks_capacity", grid.config().brick_capacity},
        {"bytes_per_voxel", VoxelGrid::kBytesPerVoxel}}},
      {"heap_allocations", HeapWatch::Counting() ? Json(run.heap_allocations) : Json(nullptr)}};
  if (run.window) {
    figures["window"] = {{"moves", run.window->moves()},
                         {"move_ms_max", Rounded(run.move_ms)},
                         {"bricks_left", run.window->left().size()},
                         {"known_outside", run.window->known_outside()}};
  }
  if (!options.rays.empty()) {
    figures["rays"] = {{"count", input.rays.rays.size()},
                       {"max_range_m", input.rays.max_range_m},
                       {"unknown_ends", RayJson(run.stop_at_unknown)},
                       {"unknown_ignored", RayJson(run.ignore_unknown)}};
  }
  if (!options.views.empty()) {
    figures["views"] = ViewJson(run);
  }
  return figures;
}

std::string MapTable(const Json& f) {
  const Json& insertion = f["insertion"];
  const Json& ms = insertion["ms_per_scan"];
  const Json& map = f["map"];
  const Json& memory = f["memory"];
  std::string table = fmt::format(
      "scans       {}, {} points, {} rejected, {} refused{}\n"
      "insertion   ms a scan: mean {:.3f}, p50 {:.3f}, max {:.3f}; least of {} passes\n"
      "map         {} free, {} occupied, {} unknown voxels of {} m\n"
      "memory      {} bytes in all; {} of {} bricks, {:.3f} bytes a voxel\n",
      f["scans"].get<int>(), insertion["points"].get<int>(), insertion["rejected"].get<int>(),
      insertion["refused"].get<int>(), f["discretised"].get<bool>() ? ", discretised" : "",
      ms["mean"].get<double>(), ms["p50"].get<double>(), ms["max"].get<double>(),
      f["passes"].get<int>(), map["free"].get<int>(), map["occupied"].get<int>(),
      map["unknown"].get<int>(), f["width_m"].get<double>(), memory["bytes"].get<std::int64_t>(),
      memory["bricks_used"].get<int>(), memory["bricks_capacity"].get<int>(),
      memory["bytes_per_voxel"].get<double>());
  if (f.contains("window")) {
    const Json& window = f["window"];
    table += fmt::format(
        "window      {} moves, {:.3f} ms at most; {} bricks left it, with {} known voxels\n",
        window["moves"].get<int>(), window["move_ms_max"].get<double>(),
        window["bricks_left"].get<int>(), window["known_outside"].get<std::int64_t>());
  }
  if (f.contains("rays")) {
    for (const char* kind : {"unknown_ends", "unknown_ignored"}) {
      const Json& answers = f["rays"][kind];
      table += fmt::format("rays        {} hits of {}, {}: {:.0f} ns a ray\n",
                           answers["hits"].get<int>(), f["rays"]["count"].get<int>(),
                           kind[8] == 'e' ? "ended by unknown voxels" : "through unknown voxels",
                           answers["ns_per_ray"].get<double>());
    }
  }
  if (f.contains("views")) {
    const Json& views = f["views"];
    table += fmt::format(
        "views       {}: {} unknown voxels, {} visual hits, {} uncovered of {} coverage hits; "
        "{:.1f} ms\n",
        views["count"].get<int>(), views["unknown"].get<std::int64_t>(),
        views["visual_hits"].get<std::int64_t>(), views["uncovered_hits"].get<std::int64_t>(),
        views["coverage_hits"].get<std::int64_t>(), views["ms"].get<double>());
  }
  return table + fmt::format("heap        {} allocations\n", f["heap_allocations"].dump());
}

}  // namespace pipewright::hil
