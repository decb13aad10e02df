// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "perception/map/voxel_grid.h"
#include "tests/bench/map_scenes.h"

namespace pipewright::bench {

/// Sums that both maps must agree on, so that nobody is fast by doing something else.
using Checksum = std::array<std::int64_t, 4>;

/// The work, done by VoxelGrid.
class OurMap {
 public:
  explicit OurMap(const MapScene& scene);
  void Insert(std::size_t scan, bool discretize);
  Checksum Known() const;
  Checksum CastRays(std::size_t view);  ///< unknown voxels ignored, 5 m
  Checksum Evaluate(std::size_t view);

 private:
  const MapScene& scene_;
  VoxelGrid grid_;
  std::vector<RayHit> hits_;
  std::vector<Vector3f> ends_W_;
  std::vector<SegmentTrace> traces_;
};

/// The same, done by liboctomap.
class OctomapMap {
 public:
  explicit OctomapMap(const MapScene& scene);
  void Insert(std::size_t scan, bool discretize);
  Checksum Known() const;
  Checksum CastRays(std::size_t view);
  Checksum Evaluate(std::size_t view);

 private:
  const MapScene& scene_;
  octomap::OcTree tree_{0.05};
  std::vector<octomap::Pointcloud> clouds_;
  octomap::KeyRay keys_;
};

}  // namespace pipewright::bench
