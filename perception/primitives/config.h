// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace pipewright {

/// Noise of a stereo depth camera: that of its disparity is constant, so that of depth grows with
/// z², and what it sends is rounded to steps.
///
///   σ(1/z)² = c² + (step²/12) / z⁴,    σ(z) = z² σ(1/z)
struct DepthNoise {
  double c_1pm = 0.0038;  ///< σ(z) at 1 m, in metres
  double step_m = 0.001;

  double VarianceInverse(double inverse_z_1pm) const {
    const double i2 = inverse_z_1pm * inverse_z_1pm;
    return c_1pm * c_1pm + step_m * step_m / 12 * i2 * i2;
  }
  double SigmaInverse(double inverse_z_1pm) const {
    return std::sqrt(VarianceInverse(inverse_z_1pm));
  }
};

/// What counts as a plane or a pipe, and how long it is believed.
struct PrimitiveConfig {
  DepthNoise noise;
  double inlier_sigmas = 3;  ///< a reading this near to a primitive is of it
  double chi2_max = 2;       ///< per degree of freedom; above it the shape is another one

  double plane_range_m = 3;
  int plane_draws = 48;             ///< triples a plane
  double plane_min_share = 0.015;   ///< of the image's pixels
  double plane_min_extent_m = 0.3;  ///< the shorter side: pipes are narrower
  double plane_extent_sigmas = 8;   ///< the shorter side, in σ(z): less cannot be told from a pipe
  double plane_min_fill = 0.3;      ///< share of the rectangle that was seen
  double plane_tilt_sigma_max_rad = 0.015;  ///< of one frame; a worse one is no help
  double plane_clear_sigmas = 3.5;          ///< readings this near to a plane are of no pipe
  double plane_clear_m = 0.008;             ///< and at least this

  double pipe_range_m = 2;
  int pipe_draws = 16;
  int pipe_min_points = 40;
  double pipe_radius_min_m = 0.02;
  double pipe_radius_max_m = 0.15;
  double pipe_min_length_m = 0.15;
  double pipe_min_arc_rad = 1.2;        ///< of the circumference, seen
  double pipe_min_side_arc_rad = 0.34;  ///< of it on either side of the view
  double pipe_min_roundness = 1.8;      ///< chi2 of the best plane over that of the pipe
  double pipe_max_gap_m = 0.15;         ///< along the axis; farther on it is another pipe
  double pipe_see_through_max = 0.2;    ///< share of its readings that lie behind it
  double pipe_radius_sigma_max = 0.2;   ///< σ(r)/r

  int confirm_frames = 3;      ///< matches before others get to know of it
  int contradictions_max = 8;  ///< net frames that see through it before it goes
  int tentative_frames = 30;   ///< a track not confirmed within so many frames goes

  double gate_angle_rad = 0.12;
  double gate_offset_m = 0.05;
  double gate_radius_m = 0.02;
  double gate_gap_m = 0.3;  ///< between the parts seen of one primitive
  double merge_angle_rad = 0.08;
  double merge_offset_m = 0.03;

  /// Error of the camera's pose that all frames share: a floor of what is stated.
  double pose_sigma_m = 0.002;
  double pose_sigma_rad = 0.002;
  double radius_sigma_m = 0.001;
  /// Random walk of a primitive against the robot, a frame: the localisation drifts.
  double drift_sigma_m = 1e-4;
  double drift_sigma_rad = 1e-4;
  /// The same for a frame that sees through a primitive.
  double doubt_sigma_m = 0.003;
  double doubt_sigma_rad = 0.003;
};

constexpr bool Valid(const PrimitiveConfig& c) {
  const bool fits = c.noise.c_1pm > 0 && c.noise.step_m >= 0 && c.inlier_sigmas > 0 &&
                    c.chi2_max > 1 && c.plane_range_m > 0 && c.plane_draws > 0 &&
                    c.plane_min_share > 0 && c.plane_min_extent_m > 0 && c.pipe_range_m > 0 &&
                    c.pipe_draws > 0 && c.pipe_min_points >= 10 && c.pipe_radius_min_m > 0 &&
                    c.pipe_radius_max_m > c.pipe_radius_min_m && c.pipe_min_length_m > 0 &&
                    c.pipe_min_arc_rad > 0 && c.pipe_max_gap_m > 0;
  const bool tracks = c.confirm_frames >= 1 && c.contradictions_max >= 1 &&
                      c.tentative_frames >= c.confirm_frames && c.gate_angle_rad > 0 &&
                      c.gate_offset_m > 0 && c.gate_radius_m > 0 && c.gate_gap_m >= 0 &&
                      c.merge_angle_rad <= c.gate_angle_rad && c.merge_offset_m <= c.gate_offset_m;
  const bool noise = c.pose_sigma_m >= 0 && c.pose_sigma_rad >= 0 && c.radius_sigma_m >= 0 &&
                     c.drift_sigma_m >= 0 && c.drift_sigma_rad >= 0 &&
                     c.doubt_sigma_m >= c.drift_sigma_m && c.doubt_sigma_rad >= c.drift_sigma_rad;
  return fits && tracks && noise;
}
static_assert(Valid(PrimitiveConfig{}));

}  // namespace pipewright
