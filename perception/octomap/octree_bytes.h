// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "perception/map/voxel_index.h"
#include "platform/core/status.h"

/// The bytes of an OctoMap file (OctoMap 1.9's AbstractOcTree and OccupancyOcTreeBase).
///
///   # Octomap OcTree file                or "# Octomap OcTree binary file"
///   id OcTree                            in any order, with comments behind '#'
///   size <nodes>
///   res <m>
///   data
///   the nodes, the root first, each followed by its children in the order of their bits
///
/// A node of an .ot is its log-odds (float32, little-endian) and a byte that has bit i set when
/// there is child i. One of a .bt is two bytes with two bits a child: 0 unknown, 1 a free leaf, 2
/// an occupied leaf, 3 a node. Child i of a cube is its half of greater x when bit 0 of i is set,
/// of greater y with bit 1, of greater z with bit 2; the root's cube is 2^16 voxels wide. A leaf
/// wider than a voxel stands for all of its cube.
namespace pipewright {

inline constexpr int kOctreeDepth = 16;

struct OctreeLeaf {
  VoxelIndex lo;                          ///< its cube's least voxel
  int voxels = 0;                         ///< along each of the cube's edges
  float log_odds = 0;                     ///< of a .bt: -kCertain or kCertain
  static constexpr float kCertain = 100;  ///< beyond any sensor model's clamps
};

struct OctreeHead {
  bool binary = false;  ///< a .bt
  double width_m = 0;   ///< of a voxel
  std::uint64_t nodes = 0;
  std::size_t body = 0;  ///< the byte at which the nodes begin
};

/// kMalformed: the text is no head of an OcTree's file.
Result<OctreeHead> ReadOctreeHead(std::string_view bytes);

/// Calls use(leaf) for each leaf, in the order of the file. Nothing is taken for granted: the work
/// is bounded by the file's size, the stack by the tree's depth.
///
/// kMalformed: the file ends within a node, goes deeper than a voxel, or has another number of
/// nodes than its head says. Leaves before that have been told.
Status ReadOctreeLeaves(std::string_view bytes, const OctreeHead& head,
                        const std::function<void(const OctreeLeaf&)>& use);

}  // namespace pipewright
