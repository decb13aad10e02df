// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hil/cli/map_window.h"
#include "hil/scans/scan_file.h"
#include "perception/map/voxel_grid.h"

namespace pipewright::hil {

struct MapOptions {
  std::string file;
  std::string rays;
  std::string views;
  std::vector<int> box;  ///< lo x y z, hi x y z of the stored voxels; empty: what the scans touch
  double window_m = 0;   ///< sides of a box that follows the scans' origins; 0: one that stands
  bool discretise = false;
  int repeat = 3;
  std::string dump;
  std::string hits;
  std::string gains;
  bool json = false;
};

/// What the command was given to read; rays and views only if asked for.
struct MapInput {
  ScanSet scans;
  RaySetFile rays;
  ViewSet views;
};

/// What a view is worth, as the reference of data sets of this kind counts it.
struct ViewCounts {
  std::uint32_t unknown = 0;         ///< voxels passed, over the visual rays
  std::uint32_t visual_hits = 0;     ///< visual rays that ended at a surface
  std::uint32_t uncovered_hits = 0;  ///< coverage rays that ended at an uncovered one
  std::uint32_t coverage_hits = 0;   ///< coverage rays that ended at one
};

/// Both ways of casting the rays, see VoxelGrid::CastRay.
struct RayAnswers {
  std::vector<RayHit> hits;
  double ns = 0;  ///< a ray, mean of the set; the least of all passes
};

struct MapRun {
  std::string error;  ///< why the set cannot be run, in words; empty when it was
  std::unique_ptr<VoxelGrid> grid;
  std::unique_ptr<MapWindow> window;  ///< of the grid; null: it stands
  double move_ms = 0;            ///< the longest of the window's moves, the least of all passes
  std::vector<float> insert_ms;  ///< one a scan, the least of all passes
  ScanStats stats;               ///< summed over the scans
  RayAnswers stop_at_unknown;
  RayAnswers ignore_unknown;
  std::vector<ViewCounts> views;
  double views_ms = 0;  ///< all of them, the least of all passes
  std::uint64_t heap_allocations = 0;
};

/// Inserts the scans in order, then casts the rays and evaluates the views. Every pass begins with
/// an empty map of the same box: all passes do the same work.
MapRun RunMap(const MapInput& input, const MapOptions& options);

}  // namespace pipewright::hil
