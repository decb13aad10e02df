// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "perception/primitives/config.h"
#include "perception/primitives/pipe_finder.h"
#include "perception/primitives/plane_finder.h"

namespace pipewright {

/// How far off points are: those of an image along their rays, from S's origin; others alike in
/// each direction.
struct PointNoise {
  std::optional<DepthNoise> depth;
  double sigma_m = 0.01;  ///< where there is no depth
};

struct ExplainConfig {
  double sigmas = 4;      ///< a point this near to a primitive is of it
  double border_m = 0.1;  ///< about the part of a primitive that was seen
};

constexpr bool Valid(const ExplainConfig& c) { return c.sigmas > 0 && c.border_m >= 0; }
static_assert(Valid(ExplainConfig{}));

/// Whether a plane or a pipe explains a point: the point lies about the part that was seen, and its
/// distance d to the surface with normal g there is noise,
///
///   d <= sigmas σ(g) max(1, chi2)^½
///
/// where chi2 is the primitive's own: what departs from its shape by more than noise, as a table
/// does that is not quite flat, does so with all its points.
/// @param p_SQ  finite; with depth noise, z > 0
bool Explains(const DetectedPlane& plane, const Vector3d& p_SQ, const PointNoise& noise,
              const ExplainConfig& config);
bool Explains(const DetectedPipe& pipe, const Vector3d& p_SQ, const PointNoise& noise,
              const ExplainConfig& config);

/// The points that no plane and no pipe explains; those that are no readings (not finite or, with
/// depth noise, not before the camera) are passed over. Cost: O(points * primitives), ~10 ns each.
///
/// @param numbers  as many as points; gets the points' numbers, ascending
/// @returns how many
int Unexplained(std::span<const Eigen::Vector3f> p_SQ, std::span<const DetectedPlane> planes,
                std::span<const DetectedPipe> pipes, const PointNoise& noise,
                const ExplainConfig& config, std::span<int> numbers);

}  // namespace pipewright
