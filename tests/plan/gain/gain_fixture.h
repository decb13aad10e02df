// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include "plan/gain/gain.h"
#include "tests/plan/gain/toy_map.h"

namespace pipewright::test {

inline bool Unknown(const VoxelGrid& map, const VoxelIndex& v) {
  return map.InWorkspace(v) && map.State(v) == VoxelState::kUnknown && !map.Residual(v);
}

inline bool Uncovered(const VoxelGrid& map, const VoxelIndex& v) {
  return map.InWorkspace(v) && map.State(v) == VoxelState::kOccupied && !map.Covered(v);
}

inline Vector3d RandomPoint(const MapConfig& config, Rng& rng) {
  const auto draw = [&](int lo, int hi) { return config.width_m * rng.Uniform(lo, hi + 1); };
  const double x = draw(config.lo.x, config.hi.x);
  const double y = draw(config.lo.y, config.hi.y);
  return {x, y, draw(config.lo.z, config.hi.z)};
}

inline Vector3d RandomDirection(Rng& rng) {
  const double x = rng.Normal();
  const double y = rng.Normal();
  return Vector3d(x, y, rng.Normal()).normalized();
}

class Gain : public testing::Test {
 protected:
  MapConfig map_config_ = SmallMapConfig();
  VoxelGrid map_{map_config_};
  GainConfig config_{.range_m = 0.45, .probe_radius_m = 0.3, .rays = 60};
  Rng rng_{7};
};

}  // namespace pipewright::test
