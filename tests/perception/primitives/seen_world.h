// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "perception/cloud/cloud.h"
#include "perception/primitives/config.h"
#include "platform/core/rng.h"

namespace pipewright::test {

/// A half-space, free where n.p > d.
struct TruePlane {
  Vector3d n_W;
  double d_m;
};

struct TruePipe {
  Vector3d from_W;
  Vector3d to_W;
  double radius_m;
};

struct TrueBall {
  Vector3d c_W;
  double radius_m;
};

/// Analytic shapes, seen by a pinhole without any of the perception's own code.
struct World {
  std::vector<TruePlane> planes;
  std::vector<TruePipe> pipes;
  std::vector<TrueBall> balls;

  /// Distance along the unit ray to the first surface; infinity where there is none.
  double Cast(const Vector3d& p_W, const Vector3d& direction_W) const;
};

struct Lens {
  int width = 106;
  int height = 60;
  double fov_rad = 1.518;  // 87 degrees
  double z_min_m = 0.17;
  double z_max_m = 6;
};

/// X_WS of a camera at `eye` that looks at `target`, its image upright.
Isometry3d LookingAt(const Vector3d& eye, const Vector3d& target);

/// One frame: depth with noise c z² and rounding, 1% without reading, as a cloud.
void See(const World& world, const Isometry3d& X_WS, const Lens& lens, const DepthNoise& noise,
         Rng& rng, Cloud& cloud);

/// A cell of 1.5 m, open at the front and the top, with floor and hall; no pipes.
World Cell();

}  // namespace pipewright::test
