// SPDX-License-Identifier: MIT
#pragma once

#include <octomap/octomap.h>

#include <string>
#include <vector>

#include "perception/map/voxel_grid.h"

namespace pipewright::test {

/// One cloud as both maps take it.
struct Scan {
  Vector3f origin_W = Vector3f::Zero();
  double max_range_m = -1;
  std::vector<Vector3f> points_W;
};

inline octomap::point3d ToOctomap(const Vector3f& p) { return {p.x(), p.y(), p.z()}; }

inline octomap::OcTreeKey KeyOf(const VoxelIndex& v) {
  const auto key = [](int i) { return static_cast<octomap::key_type>(i + 32768); };
  return {key(v.x), key(v.y), key(v.z)};
}

inline void InsertOctomap(octomap::OcTree* tree, const Scan& scan, bool discretize = false) {
  octomap::Pointcloud cloud;
  for (const Vector3f& p : scan.points_W) {
    cloud.push_back(ToOctomap(p));
  }
  tree->insertPointCloud(cloud, ToOctomap(scan.origin_W), scan.max_range_m, false, discretize);
}

inline ScanStats InsertOurs(VoxelGrid* grid, const Scan& scan, bool discretize = false) {
  const auto count = static_cast<int>(scan.points_W.size());
  return discretize
             ? grid->InsertScanDiscretized(scan.points_W.data(), count, scan.origin_W,
                                           scan.max_range_m)
             : grid->InsertScan(scan.points_W.data(), count, scan.origin_W, scan.max_range_m);
}

/// What differs inside the grid's box, in words; empty: state and log-odds of each voxel agree.
inline std::string Difference(const VoxelGrid& grid, const octomap::OcTree& tree) {
  int differ = 0;
  std::string first;
  for (int i = 0; i < grid.voxel_count(); ++i) {
    const VoxelIndex v = grid.VoxelAt(i);
    const octomap::OcTreeNode* node = tree.search(KeyOf(v));
    const VoxelState theirs = node == nullptr             ? VoxelState::kUnknown
                              : tree.isNodeOccupied(node) ? VoxelState::kOccupied
                                                          : VoxelState::kFree;
    const float log_odds = node == nullptr ? 0 : node->getLogOdds();
    if (grid.State(v) != theirs || std::abs(grid.LogOdds(v) - log_odds) > 1e-6F) {
      ++differ;
      if (first.empty()) {
        first = "voxel " + std::to_string(v.x) + " " + std::to_string(v.y) + " " +
                std::to_string(v.z) + ": ours " + std::to_string(grid.LogOdds(v)) + ", OctoMap's " +
                (node == nullptr ? "unknown" : std::to_string(log_odds));
      }
    }
  }
  return differ == 0 ? "" : std::to_string(differ) + " differ; first " + first;
}

/// A box about the origin, n voxels to each side, enough bricks for all of it.
inline MapConfig Box(int n) {
  MapConfig config;
  config.lo = config.workspace_lo = {-n, -n, -n};
  config.hi = config.workspace_hi = {n - 1, n - 1, n - 1};
  config.brick_capacity = BricksOfBox(config);
  return config;
}

}  // namespace pipewright::test
