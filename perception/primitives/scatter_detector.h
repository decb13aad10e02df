// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "perception/cloud/point_grid.h"
#include "perception/primitives/pipe_finder.h"
#include "perception/primitives/plane_finder.h"
#include "perception/primitives/thinning.h"
#include "platform/core/fixed_vector.h"
#include "platform/core/rng.h"

namespace pipewright {

/// What counts as a plane or a pipe among points of which neither order nor view is known.
struct ScatterConfig {
  double sigma_m = 0.01;  ///< error of a point in each direction: what is chosen by
  double inlier_sigmas = 3;
  double neighbour_m = 0.15;  ///< points this near have a common normal
  double chi2_max = 4;        ///< per degree of freedom, of sigma_m

  int plane_draws = 2000;
  double plane_min_share = 0.01;  ///< of the points
  int plane_min_points = 60;
  double plane_min_extent_m = 0.4;
  double plane_min_fill = 0.25;  ///< share of its rectangle that has points

  int pipe_draws = 200;
  int pipe_min_points = 60;
  double pipe_radius_min_m = 0.02;
  double pipe_radius_max_m = 0.3;
  double pipe_min_length_m = 0.3;
  double pipe_min_arc_rad = 1.2;
  double pipe_min_fill = 0.5;       ///< share of its seen sides, along all of it, with points
  double pipe_max_beside = 0.25;    ///< points within two gates but not one, over those in one
  double pipe_min_roundness = 1.8;  ///< chi2 of the best plane over that of the pipe
};

constexpr bool Valid(const ScatterConfig& c) {
  return c.sigma_m > 0 && c.inlier_sigmas > 0 && c.neighbour_m > 0 && c.chi2_max > 0 &&
         c.plane_draws > 0 && c.plane_min_points >= 10 && c.plane_min_extent_m > 0 &&
         c.pipe_draws > 0 && c.pipe_min_points >= 10 && c.pipe_radius_min_m > 0 &&
         c.pipe_radius_max_m > c.pipe_radius_min_m && c.pipe_min_length_m > 0;
}
static_assert(Valid(ScatterConfig{}));

/// Pipes, then planes among what is left, of an unorganised cloud: RANSAC over points and the
/// normals of their neighbourhoods, then total least squares on what agrees.
///
/// Clouds of more than PointGrid::kMaxPoints points are thinned, evenly in space. Frame S is the
/// cloud's own; rectangles lie along its z and x. No heap after construction; ~5 MB.
class ScatterDetector {
 public:
  static constexpr int kMaxPlanes = PlaneFinder::kMaxPlanes;
  static constexpr int kMaxPipes = PipeFinder::kMaxPipes;

  ScatterDetector(const ScatterConfig& config, std::uint64_t seed) : config_(config), rng_(seed) {}

  /// Points that are not finite are passed over. Cost: some 0.3 s for 30 000 points.
  void Detect(std::span<const Eigen::Vector3f> p_SQ);

  const FixedVector<DetectedPlane, kMaxPlanes>& planes() const { return planes_; }
  const FixedVector<DetectedPipe, kMaxPipes>& pipes() const { return pipes_; }
  int points_used() const { return points_; }

 private:
  static constexpr int kMaxSamples = 1024;
  static constexpr int kMaxPatch = 256;
  static constexpr std::uint8_t kFree = 0;
  static constexpr std::uint8_t kUsed = 1;
  static constexpr std::uint8_t kOfNothing = 2;

  void Take(std::span<const Eigen::Vector3f> p_SQ);
  void FindNormals();
  void FindPipes();
  void FindPlanes();
  void Sample(bool with_normal);
  int Patch(int center);
  std::span<const Eigen::Vector3f> Agreeing(int count) const {
    return {agreeing_.data(), static_cast<std::size_t>(count)};
  }

  bool DrawPlane(PlaneFit& best);
  int CollectPlane(const PlaneFit& plane);
  bool RefinePlane(DetectedPlane& plane);
  bool BoundPlane(int count, DetectedPlane& plane);

  bool DrawPipe(CylinderFit& best);
  bool OnPipe(int i, const CylinderFit& pipe, bool by_normal, double& s_m) const;
  int CollectPipe(const CylinderFit& pipe, bool by_normal, DetectedPipe& bounds);
  bool RefinePipe(DetectedPipe& pipe);
  bool IsPipe(int count, const DetectedPipe& pipe) const;
  void Bar(int count, std::uint8_t why);

  ScatterConfig config_;
  Rng rng_;
  FixedVector<DetectedPlane, kMaxPlanes> planes_;
  FixedVector<DetectedPipe, kMaxPipes> pipes_;
  Thinning thinning_;
  PointGrid grid_;
  int points_ = 0;
  std::array<Eigen::Vector3f, PointGrid::kMaxPoints> p_S_;
  std::array<Eigen::Vector3f, PointGrid::kMaxPoints> n_S_;    ///< zero: no normal
  std::array<std::uint8_t, PointGrid::kMaxPoints> barred_{};  ///< kFree, kUsed or kOfNothing
  int drawn_from_ = 0;  ///< whose neighbourhood the last pipe was drawn from
  int samples_ = 0;
  std::array<int, kMaxSamples> sample_{};
  std::array<Eigen::Vector3f, kMaxPatch> patch_;
  std::array<Eigen::Vector3f, kMaxPatch> patch_n_;
  // Those that agree with what is looked at.
  std::array<int, PointGrid::kMaxPoints> index_{};
  std::array<float, PointGrid::kMaxPoints> along_m_{};
  std::array<Eigen::Vector3f, PointGrid::kMaxPoints> agreeing_;
};

}  // namespace pipewright
