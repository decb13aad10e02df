// SPDX-License-Identifier: MIT
#include "hil/report/world_view.h"

#include <cmath>
#include <numbers>

namespace pipewright::hil {
namespace {

constexpr int kCorners = 24;  ///< of a drawn circle

using Polylines = std::vector<std::vector<Vector3d>>;

void AddBox(const Solid& box, Polylines& lines) {
  const Vector3d h = box.shape.size_m / 2;
  const auto at = [&](int x, int y, int z) -> Vector3d {
    return box.X_WG * Vector3d(x * h.x(), y * h.y(), z * h.z());
  };
  for (const int z : {-1, 1}) {
    lines.push_back({at(-1, -1, z), at(1, -1, z), at(1, 1, z), at(-1, 1, z), at(-1, -1, z)});
  }
  for (const int x : {-1, 1}) {
    for (const int y : {-1, 1}) {
      lines.push_back({at(x, y, -1), at(x, y, 1)});
    }
  }
}

void AddCylinder(const Solid& cylinder, Polylines& lines) {
  const double radius_m = cylinder.shape.size_m.x();
  const double half_m = cylinder.shape.size_m.y() / 2;
  const auto at = [&](int corner, double z) -> Vector3d {
    const double angle = 2 * std::numbers::pi * corner / kCorners;
    return cylinder.X_WG * Vector3d(radius_m * std::cos(angle), radius_m * std::sin(angle), z);
  };
  for (const double z : {-half_m, half_m}) {
    std::vector<Vector3d> circle;
    for (int corner = 0; corner <= kCorners; ++corner) {
      circle.push_back(at(corner, z));
    }
    lines.push_back(std::move(circle));
  }
  for (int corner = 0; corner < kCorners; corner += kCorners / 4) {
    lines.push_back({at(corner, -half_m), at(corner, half_m)});
  }
}

SurfaceState StateOf(bool covered, bool coverable) {
  if (covered) {
    return SurfaceState::kCovered;
  }
  return coverable ? SurfaceState::kMissed : SurfaceState::kOutOfReach;
}

void AddSurface(const Truth& truth, WorldView& view) {
  const std::vector<SurfaceVoxels::Voxel>& voxels = truth.surface().voxels;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    view.surface.push_back(
        {voxels[i].index, StateOf(truth.covered()[i] != 0, truth.coverable().coverable[i] != 0)});
  }
}

}  // namespace

WorldView ViewOf(const Scenario& scenario, const Truth* truth) {
  WorldView view;
  view.min_m = scenario.workspace.min_m;
  view.max_m = scenario.workspace.max_m;
  view.voxel_m = kVoxelWidth_m;
  if (truth != nullptr) {
    AddSurface(*truth, view);
  }
  for (const Solid& solid : scenario.solids) {
    switch (solid.kind) {
      case SolidKind::kBox:
        AddBox(solid, view.outlines);
        break;
      case SolidKind::kCylinder:
        AddCylinder(solid, view.outlines);
        break;
      case SolidKind::kPlane:
      case SolidKind::kMesh:
        break;  // without edges, or seen well enough by its surface
    }
  }
  return view;
}

}  // namespace pipewright::hil
