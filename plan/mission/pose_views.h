// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>

#include "perception/map/voxel_grid.h"
#include "plan/gain/gain.h"
#include "plan/motion/collision.h"
#include "platform/core/rng.h"

namespace pipewright {

struct PoseViewsConfig {
  int draws = 300;           ///< of postures, at most
  double range_m = 2.5;      ///< as far as a scan is of use: ScanLocalizerConfig::range_m
  double sigma_m = 0.03;     ///< of the way to a surface that one ray tells, voxels being coarse
  double cosine_min = 0.15;  ///< between ray and normal: less is too grazing
  double upright_min = 0.5;  ///< of a normal's horizontal part: floors tell nothing of the base
  /// How sure the base is before, where the choice of a view matters.
  double before_m = 0.03;
  double before_rad = 0.03;
};

constexpr bool Valid(const PoseViewsConfig& c) {
  return c.draws >= 0 && c.range_m > 0 && c.sigma_m > 0 && c.cosine_min >= 0 && c.cosine_min < 1 &&
         c.upright_min >= 0 && c.upright_min < 1 && c.before_m > 0 && c.before_rad > 0;
}
static_assert(Valid(PoseViewsConfig{}));

/// Postures of the arm from which the camera sees the most of what tells where the base stands.
///
/// A ray that meets a known surface at q with normal n tells of the base's (x, y, phi) as
/// registration does (see Register), with p the base's place:
///
///   I = Σ_rays J J'/σ²,   J = (n_x, n_y, n_y (q_x - p_x) - n_x (q_y - p_y))
///
/// n is the distance field's gradient one voxel before the surface. Rays that the robot itself
/// blocks, that meet something unknown first, or a floor, tell nothing.
class PoseViews {
 public:
  static constexpr int kMost = 8;
  using Views = FixedVector<ArmVector, kMost>;

  explicit PoseViews(const PoseViewsConfig& config = {}) : config_(config) {}

  /// @param camera  rays in S
  Mat<3, 3> Information(const Configuration& q, const Surroundings& around, const RaySet& camera);

  /// Trace of the pose's covariance after a look from q, phi at 1 m. [m²]
  double VarianceAfter(const Configuration& q, const Surroundings& around, const RaySet& camera);

  /// Free postures by that variance, best first, of those drawn with the base where it is: one half
  /// by the wrist alone, which needs the least room. ~40 us a draw; no heap.
  void Find(const CollisionChecker& checker, const Configuration& q, const RaySet& camera, Rng& rng,
            Views& best);

 private:
  PoseViewsConfig config_;
  RaySet open_;
  std::array<Vector3f, RaySet::kMaxRays> directions_W_{};
  std::array<RayHit, RaySet::kMaxRays> hits_{};
};

}  // namespace pipewright
