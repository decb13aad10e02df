// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "perception/localization/pipe_landmarks.h"
#include "perception/localization/surfel_map.h"
#include "platform/core/frames.h"
#include "platform/core/status.h"
#include "platform/core/time.h"

namespace pipewright {

/// A reading: a point in the sensor's frame, the standard deviation of its range along the ray, and
/// the normal of its surface towards the sensor; zero: not known.
struct ScanPoint {
  Eigen::Vector3f p_SQ;
  float sigma_m = 0;
  Eigen::Vector3f n_S = Eigen::Vector3f::Zero();
};

/// Where the base stood by one scan: (x, y, phi) in W, and how much is known of each direction. A
/// direction in which the scan tells nothing has no information; there the pose is the guess.
struct PoseFix {
  Time stamp{};
  bool fits = true;  ///< false: the scan fits nowhere near the guess; the rest then says nothing
  Vector3d pose = Vector3d::Zero();
  Mat<3, 3> information = Mat<3, 3>::Zero();
  /// Of the surfaces it was found among, the mean by what each tells of place and of heading.
  Placement placed{};
};

struct RegistrationConfig {
  int iterations = 20;
  double reach_m = 0.03;  ///< of the first step's robust kernel; halved at each step
  double step_m = 2e-4;   ///< the last step is smaller
  double step_rad = 2e-4;
  double model_m = 2e-3;    ///< what a surfel's place is no better than
  double model_rad = 0.05;  ///< and its normal, for surfaces are not quite flat
  double clear = 8;         ///< by how much information must exceed what false normals feign
  double sigma_max = 0.1;   ///< of a direction, phi at 1 m; one less known has too much else in it
  double alike_cosine = 0.5;  ///< between a point's normal and its surfel's; less: other surfaces
  double view_cosine = 0.15;  ///< between ray and normal: less is too grazing
  int points_min = 100;
  double known_min = 0;      ///< share of the scan that must lie on known surfaces
  double inliers_min = 0.6;  ///< share of the associated points within three sigma at the end
};

constexpr bool Valid(const RegistrationConfig& c) {
  return c.iterations > 0 && c.reach_m >= 0 && c.step_m > 0 && c.step_rad > 0 && c.model_m > 0 &&
         c.model_rad >= 0 && c.clear > 1 && c.sigma_max > 0 && c.view_cosine >= 0 &&
         c.points_min >= 3 && c.known_min >= 0 && c.known_min <= 1 && c.inliers_min >= 0 &&
         c.inliers_min <= 1;
}

struct RegistrationFigures {
  Vector3d pose = Vector3d::Zero();  ///< where it ended, fit or not
  int iterations = 0;
  int associated = 0;
  int inliers = 0;
  double inlier_share = 0;
  double chi2 = 0;     ///< per degree of freedom, of the inliers
  int directions = 0;  ///< of (x, y, phi) that the scan determines
};

/// How a reading lies to a surface that is known.
struct Misfit {
  double r_m = 0;     ///< n'(q - p)
  double var_m2 = 0;  ///< what σ² of Register() says of it
  double cosine = 0;  ///< between the ray back and the normal; not positive: the other side
};

Misfit MisfitOf(const Surfel& surfel, float sigma_m, const Vector3d& p_WQ, const Vector3d& p_WS,
                double model_m);

/// Kernel of what counts as an inlier: sigmas of MisfitOf().
inline constexpr double kInlierSigmas = 3;

/// X_WB of a base at (x, y, phi).
Isometry3d BaseAt(const Vector3d& pose);

/// Moves the base in the plane, from `start` on, until the scan lies on the pipes and the map's
/// surfels.
///
/// The camera is fixed in B by the arm's joints (X_BS), so that only (x, y, phi) is free. With the
/// point q = R(phi) p_BQ + (x, y, 0) and its surfel (p, n), or a pipe's surface at q:
///
///   r = n'(q - p),   J = ∂r/∂(x, y, phi) = B n,   B = [x', y', (z × R p_BQ)']
///   σ² = σ_range² (n'ray)² + σ²(n'p) + σ²(n) |q - p|² + rough² + model_m²
///   minimise Σ ρ(r/σ_k),    σ_k² = σ² + (reach/2^k)²
///
/// by Gauss-Newton with Geman and McClure's weights w = 1/(1 + (r/3σ_k)²)²/σ_k²; points are
/// associated anew at each step, none farther from its surfel than SurfelMap::reach_m(), nor with a
/// normal unlike the surfel's: the narrow end of a wall has no surfel, only the wall beside it.
/// What the base placed when it was less sure of itself counts less beside what it placed better:
/// by how much a surfel's placement exceeds the best one's (of those that tell: no floor) is added
/// to σ_k² in its weight, and to σ² in what counts as an inlier: that it is off contradicts
/// nothing.
///
/// A wall does not hold the base along itself. But its normals are not exact, and their errors
/// feign information there, E Σ w J J' = H + H_false, which grows with the number of points:
///
///   H_false = Σ w (σ²(n) + model_rad²) B (1 - n n') B'
///
/// So H = Σ w J J' is split into its eigenvectors (with phi as a way at 1 m), and one whose
/// information is not `clear` times what is feigned is left out: the base is not moved along it,
/// and it has no information in the fix; nor has one that is less known than sigma_max. The rest is
/// what is stated, less H_false, over chi2 where the fit is worse than the noise. Where the scan
/// tells nothing, the fix is the guess.
///
/// Cost: iterations * points * up to seven look-ups. No heap.
/// @returns kUnavailable: too few points on known surfaces; kIterationLimit: it did not settle;
///          kFault: too few inliers; kInfeasible: no direction is determined; kOutOfRange: not
///          finite. `fix` is then not to be used.
Status Register(const SurfelMap& map, const PipeLandmarks& pipes, std::span<const ScanPoint> scan,
                const Isometry3d& X_BS, const Vector3d& guess, const Vector3d& start,
                const RegistrationConfig& config, PoseFix& fix, RegistrationFigures& figures);

}  // namespace pipewright
