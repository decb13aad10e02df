// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>

#include "perception/cloud/point_grid.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/frames.h"
#include "platform/core/status.h"

namespace pipewright {

struct ClusterConfig {
  double reach_m = 0.05;   ///< points this near are of one cluster
  double spacing_rad = 0;  ///< reach per range, for what one camera saw; 0: reach is constant
  int count_min = 10;      ///< points of a cluster; fewer are noise
};

/// Below one half a reach differs from its neighbour's by less than twice.
constexpr bool Valid(const ClusterConfig& c) {
  return c.reach_m > 0 && 0 <= c.spacing_rad && c.spacing_rad <= 0.5 && c.count_min >= 1;
}
static_assert(Valid(ClusterConfig{}));

/// Points that hang together, in the frame S of the cloud they are of.
struct PointCluster {
  int points = 0;
  int first = 0;  ///< the least number of a point of it
  Vector3d centroid_S = Vector3d::Zero();
  Vector3d min_S = Vector3d::Zero();  ///< of the box along the axes of S that holds it
  Vector3d max_S = Vector3d::Zero();
  Vector3d spread_m = Vector3d::Zero();  ///< standard deviations along its own axes, largest first
};

/// Euclidean clusters: the parts into which a cloud falls when points are joined that are near.
///
/// Two points are of one cluster when a chain of points leads from one to the other, of which each
/// p and its next q are near,
///
///   |p - q| <= min(ρ(p), ρ(q)),   ρ(p) = max(reach_m, spacing_rad |p|)
///
/// in single precision. The points that a depth camera at S's origin sees on a surface lie the
/// farther apart the farther the surface is: with a constant ρ, far ones fall to pieces. Of two
/// points the nearer one's reach counts, so that a thing close by stays apart from what is behind.
///
/// The points are flooded over a grid of cubes as wide as the reach; what is reached leaves the
/// grid. Where reaches differ, this is done once an octave of them, with the points of that octave
/// and the next, and what the octaves found is united.
///
/// Clusters come largest first, of those of one size the one that holds the first point; apart from
/// which is first, they do not depend on the points' order. 1.6 MB, no heap.
///
/// [Rusu] R. B. Rusu, Semantic 3D Object Maps for Everyday Manipulation in Human Living
///        Environments, PhD thesis, TU München 2009: Euclidean cluster extraction; as clustering
///        it is single linkage (P. H. A. Sneath, J. Gen. Microbiology 17, 1957), cut at the reach.
class ClusterFinder {
 public:
  static constexpr int kMaxPoints = PointGrid::kMaxPoints;
  static constexpr int kMaxClusters = 256;
  static constexpr int kNone = -1;
  static constexpr double kFar_reaches = 65536;  ///< farther out, floats cannot tell neighbours

  /// Cost: O(points), some 0.4 us each, and 1 us where reaches grow. Only clumps that are less than
  /// two reaches apart, but not within one, are compared point by point: 10 us each in two of
  /// kMaxPoints / 2.
  ///
  /// @returns kOutOfRange when a coordinate is not finite, or beyond kFar_reaches * reach_m: there
  ///          are then no clusters. kFull when there are more points than kMaxPoints, of which the
  ///          first are taken, or more clusters than kMaxClusters, of which the largest are kept.
  Status Find(std::span<const Eigen::Vector3f> p_SQ, const ClusterConfig& config);

  const FixedVector<PointCluster, kMaxClusters>& clusters() const { return clusters_; }

  /// The cluster of each point taken, by its place in clusters(); kNone: it is noise, or of a
  /// cluster there was no room for.
  std::span<const int> labels() const { return {label_.data(), static_cast<std::size_t>(points_)}; }

  int points_refused() const { return points_refused_; }
  int clusters_refused() const { return clusters_refused_; }

 private:
  static constexpr int kOctaves = 20;

  Status Take(std::span<const Eigen::Vector3f> p_SQ, const ClusterConfig& config);
  void Flood(int begin, int end, float width_m);
  int Root(int point);
  void Unite(int a, int b);
  void Rank(int count_min);
  void Measure(std::span<const Eigen::Vector3f> p_SQ);

  FixedVector<PointCluster, kMaxClusters> clusters_;
  int points_ = 0;
  int points_refused_ = 0;
  int clusters_refused_ = 0;
  PointGrid grid_;
  // The points by octaves of their reach; those of octave k begin at octave_[k].
  std::array<int, kOctaves + 1> octave_{};
  std::array<Eigen::Vector3f, kMaxPoints> p_S_;
  std::array<float, kMaxPoints> reach_m_{};
  std::array<int, kMaxPoints> number_{};
  std::array<bool, kMaxPoints> reached_{};
  std::array<int, kMaxPoints> queue_{};
  // By the points' own numbers.
  std::array<int, kMaxPoints> parent_{};  ///< no greater; a root is its own
  std::array<int, kMaxPoints> count_{};   ///< of a root's cluster
  std::array<int, kMaxPoints> label_{};
};

}  // namespace pipewright
