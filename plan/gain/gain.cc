// SPDX-License-Identifier: MIT
#include "plan/gain/gain.h"

#include <algorithm>
#include <cassert>
#include <numbers>

#include "perception/map/voxel_grid.h"
#include "plan/gain/cells.h"

namespace pipewright {
namespace {

constexpr double kNatsPerVoxel =
    std::numbers::ln2;  // (18) at p = 0.5; (22) with its sign corrected

ViewGain GainOf(int unknown, int uncovered) {
  return {kNatsPerVoxel * unknown, kNatsPerVoxel * uncovered, unknown, uncovered};
}

}  // namespace

GainEvaluator::GainEvaluator(const GainConfig& config, const MapConfig& map)
    : config_(config), cells_(std::make_unique<Cells>(map)) {
  assert(Valid(config));
}

GainEvaluator::~GainEvaluator() = default;

void GainEvaluator::Update(const VoxelGrid& map, std::span<const std::uint8_t> ignored) {
  Cells& c = *cells_;
  assert(ignored.empty() || static_cast<int>(ignored.size()) == c.workspace_voxels);
  for (int z = c.map.lo.z; z <= c.map.hi.z; ++z) {
    for (int y = c.map.lo.y; y <= c.map.hi.y; ++y) {
      for (int x = c.map.lo.x; x <= c.map.hi.x; ++x) {
        const VoxelIndex v{x, y, z};
        const int cell = c.Index(v);
        const int in_workspace = c.workspace_index[cell];
        const bool inside = in_workspace >= 0;
        const bool counted = inside && (ignored.empty() || ignored[in_workspace] == 0);
        int flags = inside ? Cells::kInWorkspace : 0;
        flags |= inside && !counted ? Cells::kIgnored : 0;
        switch (map.State(v)) {
          case VoxelState::kFree:
            flags |= Cells::kFree;
            if (config_.solid_surfaces && counted && map.SurfaceLeftAt(map.IndexOf(v))) {
              flags |= Cells::kUncovered;
            }
            break;
          case VoxelState::kUnknown:
            flags |= counted && !map.Residual(v) ? Cells::kUnknown : 0;
            flags |= inside || map.Swept(v) ? 0 : Cells::kRoom;
            break;
          case VoxelState::kOccupied:
            flags |= Cells::kOccupied;
            flags |= counted && !map.Covered(v) ? Cells::kUncovered : 0;
            break;
        }
        c.flags[cell] = static_cast<std::uint8_t>(flags);
      }
    }
  }
  c.surface = {};
  c.LayPlanes();
  CollectLists();
}

void GainEvaluator::SetSurface(std::span<const SurfacePatch> patches) { cells_->surface = patches; }

bool GainEvaluator::SurfaceMet(const Vector3d& p_WP, const SurfacePatch& patch) const {
  constexpr double kGrazing = 0.05;  // cosine of the flattest angle that counts
  constexpr double kOwnCells = 1.5;  // the surface's own voxels do not hide it
  const Cells& c = *cells_;
  const Vector3d way = patch.p_W - p_WP;
  const double distance_m = way.norm();
  const Vector3d origin = c.InCells(p_WP);
  if (!(distance_m <= config_.probe_radius_m) || !c.InBox(origin) ||
      -patch.n_W.dot(way) < kGrazing * distance_m) {
    return false;
  }
  const double cells = distance_m / c.map.width_m;
  return cells <= kOwnCells || !c.Blocked(origin, way / distance_m, cells - kOwnCells);
}

void GainEvaluator::CollectLists() {
  Cells& c = *cells_;
  c.unknown.clear();
  c.frontier.clear();
  c.uncovered.clear();
  const VoxelIndex& lo = c.map.workspace_lo;
  const VoxelIndex& hi = c.map.workspace_hi;
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        const VoxelIndex v{x, y, z};
        const int cell = c.Index(v);
        if ((c.flags[cell] & Cells::kUncovered) != 0) {
          c.uncovered.push_back(v);
        }
        if ((c.flags[cell] & Cells::kUnknown) == 0) {
          continue;
        }
        c.unknown.push_back(v);
        const int beside = c.flags[cell - 1] | c.flags[cell + 1] | c.flags[cell - c.nx] |
                           c.flags[cell + c.nx] | c.flags[cell - c.nx * c.ny] |
                           c.flags[cell + c.nx * c.ny];
        if ((beside & Cells::kFree) != 0) {
          c.frontier.push_back(v);
        }
      }
    }
  }
}

std::span<const VoxelIndex> GainEvaluator::Frontier() const { return cells_->frontier; }
std::span<const VoxelIndex> GainEvaluator::Uncovered() const { return cells_->uncovered; }
std::span<const VoxelIndex> GainEvaluator::Unknown() const { return cells_->unknown; }

/// How many unknown voxels `camera` passes at X_WS: once a ray, or once until they are forgotten.
int GainEvaluator::CountUnknown(const Isometry3d& X_WS, const RaySet& camera, GainCount count) {
  Cells& c = *cells_;
  const Vector3d origin = c.InCells(X_WS.translation());
  if (!c.InBox(origin)) {
    return 0;
  }
  int rays = c.Turn(X_WS, camera);
  if (config_.range_min_m > 0) {
    rays = c.DropBlocked(origin, rays, config_.range_min_m / c.map.width_m);
  }
  return c.Gather(origin, rays, config_.range_m / c.map.width_m, Cells::kUnknown, count);
}

/// Calls found(cell) for every uncovered voxel within the probe's radius and in line of sight, once
/// a stamp.
template <typename Found>
void GainEvaluator::SearchUncovered(const Vector3d& p_WP, Found found) {
  Cells& c = *cells_;
  const Vector3d origin = c.InCells(p_WP);
  if (!c.InBox(origin)) {
    return;
  }
  const double radius = config_.probe_radius_m / c.map.width_m;
  for (const VoxelIndex& v : c.uncovered) {
    const Vector3d way = c.CenterInCells(v) - origin;
    const int cell = c.Index(v);
    if (way.squaredNorm() <= radius * radius && c.probe_stamps[cell] != c.stamp &&
        c.Seen(origin, v)) {
      c.probe_stamps[cell] = c.stamp;
      found(cell);
    }
  }
  for (const SurfacePatch& patch : c.surface) {
    const int cell = c.Index(patch.voxel);
    if (c.probe_stamps[cell] != c.stamp && (c.flags[cell] & Cells::kIgnored) == 0 &&
        SurfaceMet(p_WP, patch)) {
      c.probe_stamps[cell] = c.stamp;
      found(cell);
    }
  }
}

ViewGain GainEvaluator::Evaluate(const Viewpoint& view, const RaySet& camera, const RaySet& probe,
                                 GainCount count) {
  Cells& c = *cells_;
  c.Forget();
  const int unknown = CountUnknown(view.X_WS, camera, count);
  const Vector3d origin = c.InCells(view.p_WP);
  if (!c.InBox(origin)) {
    return GainOf(unknown, 0);
  }
  const int rays = c.Turn(Isometry3d::Identity(), probe);
  const double radius = config_.probe_radius_m / c.map.width_m;
  return GainOf(unknown, c.Gather(origin, rays, radius, Cells::kUncovered, count));
}

ViewGain GainEvaluator::EvaluateExact(const Viewpoint& view, const RaySet& camera) {
  BeginWay();
  return NextOnWay(view, camera);
}

void GainEvaluator::BeginWay() { cells_->Forget(); }

ViewGain GainEvaluator::NextOnWay(const Vector3d& p_WP) {
  int uncovered = 0;
  SearchUncovered(p_WP, [&](int) { ++uncovered; });
  return GainOf(0, uncovered);
}

ViewGain GainEvaluator::NextOnWay(const Viewpoint& view, const RaySet& camera) {
  const int unknown = CountUnknown(view.X_WS, camera, GainCount::kDistinct);
  int uncovered = 0;
  SearchUncovered(view.p_WP, [&](int) { ++uncovered; });
  return GainOf(unknown, uncovered);
}

int GainEvaluator::RoomCount(const Isometry3d& X_WS, const RaySet& camera, double range_m) {
  Cells& c = *cells_;
  const Vector3d origin = c.InCells(X_WS.translation());
  if (!c.InBox(origin)) {
    return 0;
  }
  c.Forget();
  const int rays = c.Turn(X_WS, camera);
  return c.Gather(origin, rays, range_m / c.map.width_m, Cells::kRoom, GainCount::kDistinct);
}

void GainEvaluator::EvaluateAll(std::span<const Viewpoint> views, const RaySet& camera,
                                const RaySet& probe, GainCount how, std::span<ViewGain> gains) {
  assert(views.size() <= gains.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    gains[i] = Evaluate(views[i], camera, probe, how);
  }
}

void GainEvaluator::Tally(const Viewpoint& view, const RaySet& camera,
                          std::span<std::uint8_t> tally) {
  BeginWay();
  TallyOnWay(view, camera, tally);
}

void GainEvaluator::TallyOnWay(const Viewpoint& view, const RaySet& camera,
                               std::span<std::uint8_t> tally) {
  assert(static_cast<int>(tally.size()) == workspace_voxels());
  const auto add = [&](int cell) {
    std::uint8_t& count = tally[cells_->workspace_index[cell]];
    count = static_cast<std::uint8_t>(count + (count < 255 ? 1 : 0));
  };
  const int before = cells_->taken_count;
  CountUnknown(view.X_WS, camera, GainCount::kDistinct);
  std::for_each(cells_->taken.begin() + before, cells_->taken.begin() + cells_->taken_count, add);
  SearchUncovered(view.p_WP, add);
}

bool GainEvaluator::InSight(const Vector3d& p_W, const VoxelIndex& target) const {
  const Cells& c = *cells_;
  const Vector3d origin = c.InCells(p_W);
  return c.InBox(origin) && c.Seen(origin, target);
}

int GainEvaluator::WorkspaceIndex(const VoxelIndex& v) const {
  return cells_->workspace_index[cells_->Index(v)];
}

int GainEvaluator::workspace_voxels() const { return cells_->workspace_voxels; }

std::size_t GainEvaluator::MemoryBytes() const {
  const Cells& c = *cells_;
  const std::size_t per_cell = sizeof(c.flags[0]) + sizeof(c.taken[0]) + sizeof(c.probe_stamps[0]) +
                               sizeof(c.workspace_index[0]);
  const std::size_t bits = c.planes.size() * c.planes[0].size() + c.marks.size();
  return sizeof(Cells) + c.flags.size() * per_cell + bits * sizeof(c.marks[0]) +
         3 * static_cast<std::size_t>(c.workspace_voxels) * sizeof(VoxelIndex);
}

}  // namespace pipewright
