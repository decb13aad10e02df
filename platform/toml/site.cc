// SPDX-License-Identifier: MIT
#include "platform/toml/site.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "platform/toml/toml_table.h"

namespace pipewright {
namespace {

constexpr double kFar_m = 100;  // the world: coordinates beyond are a slip of the pen
constexpr double kTurn_rad = 4 * std::numbers::pi;
constexpr double kMaxSide_m = 10;     // of the workspace and the map
constexpr double kMapMargin_m = 0.5;  // around the workspace
constexpr double kStartRoom_m = 0.6;  // around the start: half a base, and room to turn

BoxRegion ReadRegion(TomlTable& table, std::string_view min, std::string_view max) {
  BoxRegion region{table.Vector(min, -kFar_m, kFar_m), table.Vector(max, -kFar_m, kFar_m)};
  const Vector3d size = region.max_m - region.min_m;
  if (!(size.array() >= kVoxelWidth_m).all()) {
    table.Error(max, "must be greater than " + std::string(min) + " by a voxel (0.05 m) at least");
  } else if (!(size.array() <= kMaxSide_m).all()) {
    table.Error(max, "the box must not be longer than 10 m");
  }
  table.Finish();
  return region;
}

void ReadStart(TomlTable& table, StartPose& start) {
  start.where = table.Where();
  start.x_m = table.Number("x_m", -kFar_m, kFar_m);
  start.y_m = table.Number("y_m", -kFar_m, kFar_m);
  start.yaw_rad = table.Number("yaw_rad", -kTurn_rad, kTurn_rad);
  if (table.Has("joints_rad")) {
    start.joints_rad = table.Numbers("joints_rad", 7, -kTurn_rad, kTurn_rad);
  }
  start.clearance_m = table.Number("clearance_m", 0, 2, start.clearance_m);
  table.Finish();
}

/// W with a margin around it, and wide enough for a robot at the start.
BoxRegion DefaultMap(const BoxRegion& workspace, const StartPose& start) {
  const Vector3d start_m(start.x_m, start.y_m, workspace.min_m.z());
  const Vector3d margin = Vector3d::Constant(kMapMargin_m);
  const Vector3d room(kStartRoom_m, kStartRoom_m, 0);
  BoxRegion map{(workspace.min_m - margin).cwiseMin(start_m - room),
                (workspace.max_m + margin).cwiseMax(start_m + room)};
  map.min_m.z() = std::min(-0.1, workspace.min_m.z());
  return map;
}

/// When workspace and start are known.
void ReadMap(TomlTable& root, Site& site) {
  const StartPose& start = site.start;
  if (auto table = root.Table("map", false)) {
    site.map = ReadRegion(*table, "lo_m", "hi_m");
    const BoxRegion& map = site.map;
    if ((map.min_m.array() > site.workspace.min_m.array()).any() ||
        (map.max_m.array() < site.workspace.max_m.array()).any()) {
      table->Error("lo_m", "the map must hold the whole workspace");
    } else if (start.x_m < map.min_m.x() || start.x_m > map.max_m.x() ||
               start.y_m < map.min_m.y() || start.y_m > map.max_m.y()) {
      table->Error("lo_m", "the map must hold the place where the robot starts");
    }
    return;
  }
  site.map = DefaultMap(site.workspace, start);
  if (!((site.map.max_m - site.map.min_m).array() <= kMaxSide_m).all()) {
    root.Error("start", "too far from the workspace: a map of both would be longer than 10 m");
  }
}

}  // namespace

void ReadSite(TomlTable& root, Site& site) {
  auto workspace = root.Table("workspace", true);
  auto start = root.Table("start", true);
  if (workspace) {
    site.workspace = ReadRegion(*workspace, "min_m", "max_m");
  }
  if (start) {
    ReadStart(*start, site.start);
  }
  if (workspace && start) {
    ReadMap(root, site);
  } else {
    root.Table("map", false);
  }
}

VoxelRange VoxelsOf(const BoxRegion& region) {
  // A bound within a nanometre of a voxel face is meant to be on it.
  constexpr double kSlack = 1e-6;
  VoxelRange range;
  for (int i = 0; i < 3; ++i) {
    range.lo[i] = static_cast<int>(std::floor(region.min_m[i] / kVoxelWidth_m + kSlack));
    range.hi[i] = static_cast<int>(std::ceil(region.max_m[i] / kVoxelWidth_m - kSlack)) - 1;
  }
  return range;
}

}  // namespace pipewright
