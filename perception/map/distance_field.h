// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "perception/map/voxel_grid.h"

namespace pipewright {

/// The obstacle nearest to a point. distance is to the obstacle's voxel BOX, 0 inside it.
struct Nearest {
  double distance_m = 0;
  Vector3d p_W = Vector3d::Zero();          ///< the closest point of the box
  Vector3d direction_W = Vector3d::Zero();  ///< unit, from the obstacle to the point; 0 inside it
  VoxelIndex voxel;
  bool unknown = false;  ///< an obstacle because it was never seen, not because it was hit
  bool any = false;      ///< false: no obstacle within the range, and distance_m is the range
};

/// Distance to the obstacles of a VoxelGrid (VoxelGrid::Obstacle), exact Euclidean feature
/// transform truncated at config.field_range_m.
///
/// Each cell holds the offset to the obstacle whose centre is nearest to its own. A query looks at
/// the features of the cells around the point and takes the nearest box among them, so it never
/// says less than the truth. It says more only when the nearest box is no neighbour's feature: by
/// at most 0.25 widths (half of it is the largest that tests have met), and only beyond one width;
/// nearer than that it is exact. What lies outside the grid's box is no obstacle unless
/// config.outside_is_obstacle, then the box's walls are.
///
/// A field that was never updated knows nothing and answers as inside an unknown obstacle.
/// Copies of fields of one configuration do not allocate. Update: see the bench; linear in cells.
class DistanceField {
 public:
  DistanceField();  ///< empty: no storage, answers 0
  explicit DistanceField(const MapConfig& config);
  DistanceField(const DistanceField&);
  DistanceField& operator=(const DistanceField&);
  ~DistanceField();

  /// Rebuilds from the grid, whose config must be this field's. Returns at once when the grid has
  /// not changed since the last call.
  void Update(const VoxelGrid& grid);

  /// NearestObstacle's distance. [m]
  double Distance(const Vector3d& p_W) const { return NearestObstacle(p_W).distance_m; }
  Nearest NearestObstacle(const Vector3d& p_W) const;

  /// A lower bound of the distance from one cell's entry alone, at most two widths below: for broad
  /// phases. [m]
  double DistanceAtLeast(const Vector3d& p_W) const;

  /// Nearest column that has an obstacle with its centre between column_lo_m and column_hi_m; z of
  /// every answer is 0, distance in the plane to the column's square.
  Nearest NearestColumn(double x_m, double y_m) const;

  bool empty() const { return cells_.empty(); }
  std::int64_t MemoryBytes() const;

 private:
  MapConfig config_;
  int nx_ = 0;
  int ny_ = 0;
  int nz_ = 0;
  int range_ = 0;  // voxels
  std::uint64_t revision_ = 0;
  std::vector<std::int32_t> cells_;  // squared distance and offset to the nearest obstacle
  std::vector<std::int32_t> columns_;
  std::vector<std::int32_t> scratch_;
  std::vector<std::uint64_t> unknown_;  // a bit per cell: obstacle because unknown
  std::vector<std::uint8_t> column_unknown_;
};

}  // namespace pipewright
