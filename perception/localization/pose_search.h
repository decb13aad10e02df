// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "perception/localization/scan_registration.h"

namespace pipewright {

struct PoseSearchConfig {
  double turn_rad = 0.4;  ///< to either side
  double turn_step_rad = 0.05;
  double way_m = 0.2;  ///< each way
  double way_step_m = 0.1;
  double width_m = 0.05;  ///< of the score: how far off a step of the grid may leave a point
  int points = 192;       ///< of the scan, evenly
};

constexpr bool Valid(const PoseSearchConfig& c) {
  return c.turn_rad >= 0 && c.turn_step_rad > 0 && c.way_m >= 0 && c.way_step_m > 0 &&
         c.width_m > 0 && c.points > 0;
}

/// Where to begin a registration of a base that may be anywhere near its guess: the pose of a grid
/// about it, (x, y, phi), that the scan fits best,
///
///   max Σ 1/(1 + (r/width)²)    over the points whose surfel, or pipe, has a normal like theirs
///
/// with r of Register(). First each heading at the guess's place, then each place at the best
/// headings. The guess itself wins where nothing is better than it by a tenth.
///
/// Cost: about 100 poses, each `points` times up to seven look-ups: some ms. No heap.
Vector3d BestStart(const SurfelMap& map, const PipeLandmarks& pipes,
                   std::span<const ScanPoint> scan, const Isometry3d& X_BS, const Vector3d& guess,
                   const PoseSearchConfig& config = {});

}  // namespace pipewright
