// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "perception/map/feature_transform.h"
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

/// The field between the centres of its cells.
struct SmoothDistance {
  double distance_m = 0;
  Vector3d gradient_W = Vector3d::Zero();  ///< d distance / d p, m/m
};

/// Distance to the obstacles of a VoxelGrid (VoxelGrid::Obstacle), exact Euclidean feature
/// transform truncated at config.field_range_m.
///
/// Each cell holds the offset to the obstacle whose centre is nearest to its own. A query takes the
/// nearest box among the features of the 27 cells around the point, so it never says less than the
/// truth and below one width it is exact: every nearer box is one of the 27 itself. Beyond that it
/// may say up to two diagonals more in theory; 0.18 widths is the most that 450,000 random queries
/// have met.
/// What lies outside the grid's box is no obstacle unless config.outside_is_obstacle; then all of
/// it is. For a point outside the box, a query starts from the nearest cell of the box and may say
/// more by as much as the point is outside.
///
/// A field that was never updated knows nothing and answers as inside an unknown obstacle.
/// Copies between fields of one configuration do not allocate, nor does Update.
class DistanceField {
 public:
  DistanceField();  ///< empty: no storage, answers 0
  explicit DistanceField(const MapConfig& config);
  /// A copy has the answers, not what Update() remembers: its first one takes all cells anew.
  DistanceField(const DistanceField&);
  DistanceField& operator=(const DistanceField&);
  ~DistanceField();

  /// Follows the grid, whose config must be this field's; always the same grid, or a copy of it;
  /// also where its window moves to.
  /// Looks only at bricks that changed since the last call, and changes only cells that what
  /// changed can reach: the field is that of all cells taken anew, bit for bit. Returns at once
  /// when nothing changed. O(bricks + changed rows x range); at most the whole, O(cells x distance
  /// to the obstacles), about 10 ns a voxel.
  void Update(const VoxelGrid& grid);

  /// NearestObstacle's distance. [m]
  double Distance(const Vector3d& p_W) const { return NearestObstacle(p_W).distance_m; }
  Nearest NearestObstacle(const Vector3d& p_W) const;

  /// Trilinear interpolation of the distances between centres, and its own derivative:
  ///
  ///   d(p) = sum_c w_c(p) d_c,   w_c = prod_i (1 - |p_i - c_i| / width)
  ///
  /// over the eight cells whose centres c are around p; d_c is the distance from c to the nearest
  /// obstacle's centre, at most field_range_m, and 0 in an obstacle. Exact at centres; anywhere off
  /// by at most sqrt(3)/2 widths from the distance to the nearest centre. The gradient is constant
  /// along its own axis within a cube of centres and jumps at its faces; each part is within +-1.
  /// Outside the outermost centres the nearest cell's value goes on, or 0 with outside_is_obstacle.
  /// A field that knows nothing, and p not finite: 0, gradient 0. O(1), eight cells read.
  SmoothDistance Interpolate(const Vector3d& p_W) const;

  /// A lower bound of the distance from one cell's entry alone, at most two widths below: for broad
  /// phases. [m]
  double DistanceAtLeast(const Vector3d& p_W) const;

  /// Nearest column that has an obstacle with its centre between column_lo_m and column_hi_m; z of
  /// every answer is 0, distance in the plane to the column's square.
  Nearest NearestColumn(double x_m, double y_m) const;

  bool empty() const { return cells_.empty(); }
  std::int64_t MemoryBytes() const;

  /// Whether both give the same answer to every question.
  friend bool operator==(const DistanceField& a, const DistanceField& b);

 private:
  bool InWay(int z) const;
  void FindChanges(const VoxelGrid& grid);
  void ReadBlock(const VoxelGrid& grid, const VoxelBox& block);
  void ReadColumns(const VoxelGrid& grid, int y, std::uint8_t* obstacle);
  bool UnknownAt(int index) const { return ((unknown_[index >> 6] >> (index & 63)) & 1U) != 0; }
  std::array<VoxelIndex, 2> WallsAt(const Vector3d& p_W, int axis, int axes) const;
  double CenterDistance(const VoxelIndex& cell) const;

  MapConfig config_;
  int nx_ = 0;
  int ny_ = 0;
  int nz_ = 0;
  int range_ = 0;  // voxels
  std::uint64_t revision_ = 0;
  std::vector<std::int32_t> cells_;  // squared distance and offset to the nearest obstacle
  std::vector<std::int32_t> columns_;
  std::vector<std::uint64_t> unknown_;  // a bit per cell: obstacle because unknown
  std::vector<std::uint8_t> column_unknown_;

  // What Update() remembers of the last one; of no use in a copy.
  bool fresh_ = false;  // what follows is of cells_
  FeatureTransform transform_;
  FeatureTransform column_transform_;
  std::vector<std::uint64_t> seen_;  // revision of each block
  std::vector<std::uint8_t> dirty_rows_;
  std::vector<std::uint8_t> dirty_column_rows_;
};

}  // namespace pipewright
