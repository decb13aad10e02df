// SPDX-License-Identifier: MIT
// F12: stores that are full.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "perception/map/voxel_grid.h"
#include "perception/primitives/tracker.h"
#include "plan/gain/surface.h"
#include "plan/motion/motion_planner.h"
#include "platform/core/rng.h"
#include "tests/bench/faults/rows.h"
#include "tests/plan/motion/cell.h"

namespace pipewright::bench {
namespace {

using std::chrono_literals::operator""ms;

/// Points of a room with a post, seen from its middle.
std::vector<Vector3f> RoomPoints(Rng& rng) {
  std::vector<Vector3f> points;
  for (int i = 0; i < 2000; ++i) {
    Vector3f p(static_cast<float>(rng.Uniform(-1.5, 1.5)),
               static_cast<float>(rng.Uniform(-1.5, 1.5)),
               static_cast<float>(rng.Uniform(-1.5, 1.5)));
    p(rng.Index(3)) = rng.Index(2) == 0 ? -1.5F : 1.5F;
    points.push_back(p);
  }
  return points;
}

MapConfig Room(int bricks) {
  MapConfig config;
  config.lo = config.workspace_lo = {-32, -32, -32};
  config.hi = config.workspace_hi = {31, 31, 31};
  config.brick_capacity = bricks == 0 ? BricksOfBox(config) : bricks;
  return config;
}

/// A map with few bricks beside one with all, fed the same: each voxel that the small one knows is
/// as the large one has it, and what it does not know was counted.
Outcome FullMap(Rng& rng, std::string& why) {
  const int bricks = 1 + rng.Index(200);
  VoxelGrid small(Room(bricks));
  VoxelGrid large(Room(0));
  for (int scan = 0; scan < 3; ++scan) {
    const std::vector<Vector3f> points = RoomPoints(rng);
    const Vector3f from(0, 0, 0.1F * static_cast<float>(scan));
    small.InsertScan(points.data(), static_cast<int>(points.size()), from, -1);
    large.InsertScan(points.data(), static_cast<int>(points.size()), from, -1);
  }
  int known = 0;
  int missing = 0;
  const MapConfig& c = small.config();
  for (VoxelIndex v = c.lo; v.x <= c.hi.x; ++v.x) {
    for (v.y = c.lo.y; v.y <= c.hi.y; ++v.y) {
      for (v.z = c.lo.z; v.z <= c.hi.z; ++v.z) {
        const bool same = small.State(v) == large.State(v);
        known += same && small.State(v) != VoxelState::kUnknown ? 1 : 0;
        missing += same ? 0 : 1;
        if (!same && small.State(v) != VoxelState::kUnknown) {
          why = "a full map says otherwise of a voxel that it knows";
          return Outcome::kWrong;
        }
      }
    }
  }
  const bool counted = (small.updates_refused() > 0) == (missing > 0);
  if (!counted || known == 0 || small.bricks_used() > bricks || large.updates_refused() != 0) {
    why = "a full map does not say so";
    return Outcome::kWrong;
  }
  return Outcome::kMasked;
}

/// One wall after the other, each seen some times from a metre away, until tracks and scene are
/// full.
Outcome FullPrimitives(Rng& rng, std::string& why) {
  const auto cloud = std::make_unique<Cloud>();
  cloud->width = 106;
  cloud->height = 60;
  for (int v = 0; v < cloud->height; ++v) {
    for (int u = 0; u < cloud->width; ++u) {
      const double z = 1 + 0.003 * rng.Normal();
      const auto i = static_cast<std::size_t>(v * cloud->width + u);
      cloud->p_SQ[i] = Vector3d(z * (u - 52.5) / 56, z * (v - 29.5) / 56, z).cast<float>();
      cloud->valid[i] = 1;
    }
  }
  cloud->valid_count = cloud->size();
  const auto tracker = std::make_unique<PrimitiveTracker>(PrimitiveConfig{}, rng.Next());
  const Vector3d step = rng.Uniform(3, 6) * Vector3d::UnitZ();
  int most = 0;
  for (int wall = 0; wall < PrimitiveTracker::kMaxTracks + 6; ++wall) {
    cloud->X_WS.translation() = wall * step;
    for (int frame = 0; frame < 8; ++frame) {
      cloud->stamp += 66ms;
      tracker->Step(*cloud);
    }
    most = std::max(most, tracker->scene().planes.size());
  }
  if (most != Scene::kMaxPlanes || tracker->counters().full == 0) {
    why = fmt::format("{} planes in the scene, {} counted as without room", most,
                      tracker->counters().full);
    return Outcome::kWrong;
  }
  return Outcome::kMasked;
}

Outcome FullCandidates(Rng& rng, std::string& why) {
  VoxelGrid map(Room(0));
  const std::vector<Vector3f> points = RoomPoints(rng);
  map.InsertScan(points.data(), static_cast<int>(points.size()), Vector3f(0, 0, 0), -1);
  const int capacity = 1 + rng.Index(100);
  SurfaceToCover small(map.config(), capacity);
  SurfaceToCover large(map.config(), 65536);
  const Status of_small = small.Update(map, Scene{}, 1);
  const Status of_large = large.Update(map, Scene{}, 1);
  if (of_small != Status::kFull || of_large != Status::kOk ||
      static_cast<int>(small.patches().size()) != capacity ||
      static_cast<int>(large.patches().size()) <= capacity) {
    why = "a full store of patches does not say so, or holds less than it could";
    return Outcome::kWrong;
  }
  return Outcome::kMasked;
}

/// Behind a wall that leaves no way: the node store of the small one is full before its samples are
/// drawn; then it still finds an easy way.
Outcome FullNodes(Rng& rng, const test::Cell& walled, std::string& why) {
  Configuration from = test::Cell::Start();
  from(0) = 0.1;
  Configuration beyond = from;
  beyond(0) = 1.4;
  Configuration near = from;
  near(2) += 0.1;
  MotionPlanner small({.node_capacity = 2 * Goal::kMaxWaypoints, .iterations = 100000});
  MotionPlanner::Path path;
  double duration_s = 0;
  const Status full = small.Plan(walled.around(), from, beyond, rng, path, &duration_s);
  const bool empty = path.empty();
  const Status then = small.Plan(walled.around(), from, near, rng, path, &duration_s);
  if (full != Status::kFull || !empty || then != Status::kOk) {
    why = "a full node store does not say so, or spoils the next plan";
    return Outcome::kWrong;
  }
  return Outcome::kMasked;
}

}  // namespace

Tally StoresFull(std::uint64_t n, std::uint64_t seed) {
  Tally tally;
  Rng rng(seed);
  test::Cell walled;
  walled.AddBox({0.75, -0.5, 0}, {0.8, 1.95, 1.65});
  for (std::uint64_t i = 0; i < n; ++i) {
    std::string why;
    const Outcome outcome = i % 4 == 0   ? FullMap(rng, why)
                            : i % 4 == 1 ? FullPrimitives(rng, why)
                            : i % 4 == 2 ? FullCandidates(rng, why)
                                         : FullNodes(rng, walled, why);
    tally.Add(outcome);
    if (!why.empty()) {
      tally.Note(why);
    }
  }
  return tally;
}

}  // namespace pipewright::bench
