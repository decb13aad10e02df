// SPDX-License-Identifier: MIT
#include "hil/cli/map_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "hil/cli/heap_watch.h"

namespace pipewright::hil {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

/// The least of what it is shown.
void KeepLeast(bool first, double value, double& least) {
  least = first ? value : std::min(least, value);
}

/// Every voxel that a ray of the scans can pass, and more to each side for what rounding can do to
/// a point on a border and to a ray at its end.
VoxelBox TouchedBy(const ScanSet& set) {
  constexpr double kFar_m = 1e4;  // beyond OctoMap's keys; such points are rejected anyway
  const double range_m = set.max_range_m < 0 ? kFar_m : set.max_range_m;
  Vector3d lo = Vector3d::Constant(kFar_m);
  Vector3d hi = -lo;
  for (const TakenScan& scan : set.scans) {
    const Vector3d o = scan.origin_W.cast<double>();
    lo = lo.cwiseMin(o);
    hi = hi.cwiseMax(o);
    for (const Vector3f& point : scan.points_W) {
      const Vector3d p = point.cast<double>();
      if (p.allFinite() && p.cwiseAbs().maxCoeff() < set.width_m * (1 << 15)) {
        lo = lo.cwiseMin(p.cwiseMax((o.array() - range_m).matrix()));
        hi = hi.cwiseMax(p.cwiseMin((o.array() + range_m).matrix()));
      }
    }
  }
  return BoxOf(lo, hi, set.width_m, 2);
}

std::string ConfigFor(const ScanSet& set, const MapOptions& options, MapConfig* config) {
  const std::vector<int>& b = options.box;
  const VoxelBox box = options.window_m > 0 ? WindowBox(options.window_m, set.width_m)
                       : b.empty()          ? TouchedBy(set)
                                            : VoxelBox{{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
  config->lo = config->workspace_lo = box.lo;
  config->hi = config->workspace_hi = box.hi;
  config->width_m = set.width_m;
  config->field_range_m = set.width_m;  // no distances are asked for
  config->brick_capacity = 1;
  const std::string words = fmt::format("voxels {} {} {} to {} {} {}", box.lo.x, box.lo.y, box.lo.z,
                                        box.hi.x, box.hi.y, box.hi.z);
  if (!Valid(*config)) {
    return fmt::format(
        "cannot store {}: at most 2^27 voxels within -32768 to 32767, lo first; choose a --box or "
        "a --window",
        words);
  }
  config->brick_capacity = BricksOfBox(*config);
  return "";
}

void Add(const ScanStats& scan, ScanStats* sum) {
  sum->points += scan.points;
  sum->rejected += scan.rejected;
  sum->hits += scan.hits;
  sum->misses += scan.misses;
  sum->refused += scan.refused;
}

/// The workload's stand-in for what a probe has covered: one voxel in four, by its OctoMap key.
bool Covered(const VoxelIndex& v) {
  const auto key = [](int i) { return static_cast<std::uint32_t>(i + 32768); };
  const std::uint32_t hash =
      (key(v.x) * 73856093U) ^ (key(v.y) * 19349663U) ^ (key(v.z) * 83492791U);
  return (hash & 3U) == 0;
}

class MapRunner {
 public:
  MapRunner(const MapInput& input, const MapOptions& options) : input_(input), options_(options) {}

  MapRun Run() {
    run_.error = ConfigFor(input_.scans, options_, &config_);
    if (!run_.error.empty()) {
      return std::move(run_);
    }
    TakeMemory();
    for (int pass = 0; pass < options_.repeat; ++pass) {
      run_.window = nullptr;  // it is of the grid before
      run_.grid = std::make_unique<VoxelGrid>(config_);
      if (options_.window_m > 0) {
        run_.window = std::make_unique<MapWindow>(*run_.grid);
      }
      kept_allocations_ = 0;
      const HeapWatch heap;
      Insert(pass == 0);
      Cast(pass == 0, false, run_.stop_at_unknown);
      Cast(pass == 0, true, run_.ignore_unknown);
      Evaluate(pass == 0);
      run_.heap_allocations += heap.allocations() - kept_allocations_;
    }
    return std::move(run_);
  }

 private:
  void TakeMemory() {
    run_.insert_ms.resize(input_.scans.scans.size());
    run_.stop_at_unknown.hits.resize(input_.rays.rays.size());
    run_.ignore_unknown.hits.resize(input_.rays.rays.size());
    run_.views.resize(input_.views.views.size());
    for (const QueryRay& ray : input_.rays.rays) {
      directions_W_.push_back(ray.direction_W);
    }
    std::size_t most = 0;
    for (const GainView& view : input_.views.views) {
      most = std::max({most, view.visual_W.size(), view.coverage_W.size()});
    }
    ends_W_.resize(most);
    traces_.resize(most);
  }

  /// @returns the time it took
  double Follow(const Vector3f& origin_W) {
    const HeapWatch heap;
    const Clock::time_point begin = Clock::now();
    run_.window->Follow(origin_W.cast<double>());
    kept_allocations_ += heap.allocations();
    return Milliseconds(Clock::now() - begin).count();
  }

  void Insert(bool first) {
    run_.stats = {};
    double move_ms = 0;
    for (std::size_t k = 0; k < input_.scans.scans.size(); ++k) {
      const TakenScan& scan = input_.scans.scans[k];
      const auto count = static_cast<int>(scan.points_W.size());
      const double range_m = input_.scans.max_range_m;
      const Vector3f* const points_W = scan.points_W.data();
      if (run_.window) {
        move_ms = std::max(move_ms, Follow(scan.origin_W));
      }
      const Clock::time_point begin = Clock::now();
      Add(options_.discretise
              ? run_.grid->InsertScanDiscretized(points_W, count, scan.origin_W, range_m)
              : run_.grid->InsertScan(points_W, count, scan.origin_W, range_m),
          &run_.stats);
      const auto took_ms = static_cast<float>(Milliseconds(Clock::now() - begin).count());
      run_.insert_ms[k] = first ? took_ms : std::min(run_.insert_ms[k], took_ms);
    }
    KeepLeast(first, move_ms, run_.move_ms);
  }

  /// Rays of one origin that stand together are cast together.
  void Cast(bool first, bool ignore_unknown, RayAnswers& answers) {
    const std::vector<QueryRay>& rays = input_.rays.rays;
    if (rays.empty()) {
      return;
    }
    const Clock::time_point begin = Clock::now();
    for (std::size_t from = 0; from < rays.size();) {
      std::size_t to = from + 1;
      while (to < rays.size() && rays[to].origin_W == rays[from].origin_W) {
        ++to;
      }
      run_.grid->CastRays(rays[from].origin_W, &directions_W_[from], static_cast<int>(to - from),
                          input_.rays.max_range_m, ignore_unknown, &answers.hits[from]);
      from = to;
    }
    const double ms = Milliseconds(Clock::now() - begin).count();
    KeepLeast(first, 1e6 * ms / static_cast<double>(rays.size()), answers.ns);
  }

  void Evaluate(bool first) {
    const ViewSet& set = input_.views;
    const Clock::time_point begin = Clock::now();
    for (std::size_t k = 0; k < set.views.size(); ++k) {
      const GainView& view = set.views[k];
      ViewCounts counts;
      Trace(view.p_W, view.visual_W, static_cast<float>(set.visual_range_m));
      for (std::size_t i = 0; i < view.visual_W.size(); ++i) {
        counts.unknown += static_cast<std::uint32_t>(traces_[i].unknown);
        counts.visual_hits += traces_[i].hit ? 1 : 0;
      }
      Trace(view.p_W, view.coverage_W, static_cast<float>(set.coverage_range_m));
      for (std::size_t i = 0; i < view.coverage_W.size(); ++i) {
        counts.coverage_hits += traces_[i].hit ? 1 : 0;
        counts.uncovered_hits += traces_[i].hit && !Covered(traces_[i].end) ? 1 : 0;
      }
      run_.views[k] = counts;
    }
    KeepLeast(first, Milliseconds(Clock::now() - begin).count(), run_.views_ms);
  }

  void Trace(const Vector3f& p_W, const std::vector<Vector3f>& directions_W, float range_m) {
    for (std::size_t i = 0; i < directions_W.size(); ++i) {
      ends_W_[i] = p_W + directions_W[i] * range_m;
    }
    run_.grid->TraceSegments(p_W, ends_W_.data(), static_cast<int>(directions_W.size()),
                             traces_.data());
  }

  const MapInput& input_;
  const MapOptions& options_;
  MapConfig config_;
  std::vector<Vector3f> directions_W_;
  std::vector<Vector3f> ends_W_;
  std::vector<SegmentTrace> traces_;
  std::uint64_t kept_allocations_ = 0;  ///< of the pass, for bricks that left the window
  MapRun run_;
};

}  // namespace

MapRun RunMap(const MapInput& input, const MapOptions& options) {
  return MapRunner(input, options).Run();
}

}  // namespace pipewright::hil
