// SPDX-License-Identifier: MIT
#include "perception/octomap/octomap_file.h"

#include <octomap/octomap.h>

#include <cmath>
#include <fstream>
#include <memory>

namespace pipewright {
namespace {

constexpr int kKeyOrigin = 32768;

octomap::OcTree TreeOf(const VoxelGrid& grid) {
  const MapConfig& c = grid.config();
  octomap::OcTree tree(c.width_m);
  tree.setProbHit(c.p_hit);
  tree.setProbMiss(c.p_miss);
  tree.setClampingThresMin(c.p_min);
  tree.setClampingThresMax(c.p_max);
  tree.setOccupancyThres(c.p_occupied);
  const auto key = [](int i) { return static_cast<octomap::key_type>(i + kKeyOrigin); };
  for (int i = 0; i < grid.voxel_count(); ++i) {
    if (grid.KnownAt(i)) {
      const VoxelIndex v = grid.VoxelAt(i);
      tree.setNodeValue(octomap::OcTreeKey(key(v.x), key(v.y), key(v.z)), grid.LogOdds(v), true);
    }
  }
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

std::unique_ptr<octomap::OcTree> ReadTree(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string first_line;
  std::getline(in, first_line);
  in.seekg(0);
  if (first_line.find("binary") != std::string::npos) {
    auto tree = std::make_unique<octomap::OcTree>(0.1);  // the file's own resolution replaces it
    return tree->readBinary(in) ? std::move(tree) : nullptr;
  }
  std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(in));
  auto* tree = dynamic_cast<octomap::OcTree*>(any.get());
  if (tree != nullptr) {
    static_cast<void>(any.release());
  }
  return std::unique_ptr<octomap::OcTree>(tree);
}

}  // namespace

Status WriteOt(const VoxelGrid& grid, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  return out && TreeOf(grid).write(out) && out.flush() ? Status::kOk : Status::kUnavailable;
}

Status WriteBt(const VoxelGrid& grid, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  return out && TreeOf(grid).writeBinary(out) && out.flush() ? Status::kOk : Status::kUnavailable;
}

Result<OctomapFileStats> ReadOctomap(const std::string& path, VoxelGrid* grid) {
  if (!std::ifstream(path)) {
    return Status::kUnavailable;
  }
  const std::unique_ptr<octomap::OcTree> tree = ReadTree(path);
  if (tree == nullptr ||
      std::abs(tree->getResolution() - grid->config().width_m) > 1e-9 * grid->config().width_m) {
    return Status::kMalformed;
  }
  OctomapFileStats stats;
  tree->expand();
  for (auto leaf = tree->begin_leafs(); leaf != tree->end_leafs(); ++leaf) {
    const octomap::OcTreeKey key = leaf.getKey();
    const VoxelIndex v{key[0] - kKeyOrigin, key[1] - kKeyOrigin, key[2] - kKeyOrigin};
    if (!grid->InBox(v)) {
      ++stats.outside;
    } else {
      ++(grid->Restore(v, leaf->getLogOdds()) ? stats.restored : stats.refused);
    }
  }
  return stats;
}

}  // namespace pipewright
