// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "perception/localization/pipe_landmarks.h"
#include "perception/localization/scan_registration.h"
#include "perception/localization/surfel_map.h"

namespace pipewright {

struct NewPointsConfig {
  double sigmas = 4;      ///< of its misfit: a reading this near to a known surface is of it
  double least_m = 0.02;  ///< and this near in any case: the pose is not exact
  double model_m = 2e-3;  ///< as RegistrationConfig's
  int loose_max = 2;      ///< points that were here before with no surfel may be of nothing
};

constexpr bool Valid(const NewPointsConfig& c) {
  return c.sigmas > 0 && c.least_m >= 0 && c.model_m >= 0 && c.loose_max >= 0;
}
static_assert(Valid(NewPointsConfig{}));

/// The readings of a scan that lie on nothing known: what stands there now and did not before, or
/// could not be seen. Their clusters (ClusterFinder) are things.
///
/// A reading is known when its misfit (see Register) to a pipe or to the map's surfel there is
///
///   |r| <= max(least_m, sigmas σ)
///
/// on either side of the surface, at whatever angle; or when the map holds more than loose_max
/// points about it that no surfel stands for. So within a cell or two (of 5 cm) of edges, of bent
/// things and of what was seen thinly nothing is new.
///
/// The map must be one that has not taken this scan: ScanLocalizer adds each scan that it trusts.
///
/// @param X_WS     the sensor's pose, as registered
/// @param numbers  as many as the scan's points; gets the new ones' places in the scan, ascending.
///                 Points that are not finite are none.
/// @returns how many. Cost: O(points), up to fourteen look-ups each. No heap.
int NewPoints(const SurfelMap& map, const PipeLandmarks& pipes, std::span<const ScanPoint> scan,
              const Isometry3d& X_WS, const NewPointsConfig& config, std::span<int> numbers);

}  // namespace pipewright
