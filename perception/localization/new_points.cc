// SPDX-License-Identifier: MIT
#include "perception/localization/new_points.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pipewright {

int NewPoints(const SurfelMap& map, const PipeLandmarks& pipes, std::span<const ScanPoint> scan,
              const Isometry3d& X_WS, const NewPointsConfig& config, std::span<int> numbers) {
  assert(Valid(config) && numbers.size() >= scan.size());
  int count = 0;
  for (int i = 0; i < static_cast<int>(scan.size()); ++i) {
    const Vector3d p_WQ = X_WS * scan[i].p_SQ.cast<double>();
    const auto is_of = [&](const Surfel& surfel) {
      const Misfit misfit =
          MisfitOf(surfel, scan[i].sigma_m, p_WQ, X_WS.translation(), config.model_m);
      return std::abs(misfit.r_m) <=
             std::max(config.least_m, config.sigmas * std::sqrt(misfit.var_m2));
    };
    Surfel of_pipe;
    const Surfel* const surfel = map.Find(p_WQ);
    const bool known = (pipes.Find(p_WQ, of_pipe) >= 0 && is_of(of_pipe)) ||
                       (surfel != nullptr && is_of(*surfel)) || map.Loose(p_WQ) > config.loose_max;
    if (!known && p_WQ.allFinite()) {
      numbers[count++] = i;
    }
  }
  return count;
}

}  // namespace pipewright
