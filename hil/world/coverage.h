// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hil/world/ray_scene.h"
#include "hil/world/scenario.h"

namespace pipewright::hil {

/// The surface of a world inside its workspace W, sampled at <= 12.5 mm and binned to voxels.
///
/// A surface voxel is a voxel of W that holds at least one sample which is not inside another
/// solid.
struct SurfaceVoxels {
  struct Voxel {
    std::array<int, 3> index{};
    int first = 0;  ///< its samples: [first, first + count)
    int count = 0;
  };
  struct Sample {
    Eigen::Vector3f p_W;
    Eigen::Vector3f n_W;  ///< outward; zero on an open mesh, which has two sides
  };
  std::vector<Voxel> voxels;  ///< ordered by x, then y, then z
  std::vector<Sample> samples;
};
SurfaceVoxels SampleSurface(const Scenario& scenario, double spacing_m = 0.0125);

/// Answers which surface voxels a probe covers: those with a sample within the radius of P and in
/// line of sight of P among the world's solids. The robot's own body does not count.
class CoverageProbe {
 public:
  CoverageProbe(const SurfaceVoxels& surface, const RayScene& rays, double radius_m)
      : surface_(surface), rays_(rays), radius_m_(radius_m) {}

  bool Covers(const Vector3d& p_WP, int voxel) const;

  /// Adds what P covers to a set; returns how many were new. Covered voxels cost nothing.
  int Add(const Vector3d& p_WP, std::vector<std::uint8_t>& covered) const;

  const SurfaceVoxels& surface() const { return surface_; }
  double radius_m() const { return radius_m_; }

 private:
  const SurfaceVoxels& surface_;
  const RayScene& rays_;
  double radius_m_;
};

}  // namespace pipewright::hil
