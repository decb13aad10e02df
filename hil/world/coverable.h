// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hil/world/coverage.h"
#include "hil/world/robot_bodies.h"
#include "hil/world/scenario.h"

namespace pipewright::hil {

/// How densely collision-free configurations are sampled.
struct CoverableConfig {
  int min_configurations = 20000;  ///< collision-free ones
  int max_configurations = 60000;
  /// Saturated when this many configurations in a row have covered nothing new.
  int saturated_after = 10000;
  std::uint64_t seed = 1;
};

/// Which surface voxels the probe can cover at all.
struct CoverableSet {
  std::vector<std::uint8_t> coverable;  ///< 0 or 1 for each surface voxel
  int count = 0;
  int configurations = 0;  ///< collision-free ones that were sampled
  bool saturated = false;
  bool from_cache = false;
};

/// Samples whole-body configurations: the base anywhere its own bodies are connected to the start
/// without touching (flood fill over x, y at 5 cm and 16 headings), the joints anywhere within
/// their limits; kept when no body touches the world or another. Each second sample varies an
/// earlier one that covered something new, so that narrow views are found. Deterministic. Some
/// tenths of a second in a 1.5 m cell.
CoverableSet ComputeCoverable(const Scenario& scenario, const RobotBodies& robot,
                              const CoverageProbe& probe, const CoverableConfig& config = {});

/// The same through a file in $XDG_CACHE_HOME/pipewright (or ~/.cache/pipewright), named by a hash
/// of all that the result depends on. A cache that cannot be read or written is no error.
CoverableSet CachedCoverable(const Scenario& scenario, const RobotBodies& robot,
                             const CoverageProbe& probe, const CoverableConfig& config = {});

}  // namespace pipewright::hil
