// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "perception/localization/scan_registration.h"
#include "platform/core/rng.h"

namespace pipewright::test {

/// A half-space, free where n.p > d.
struct Wall {
  Vector3d n;
  double d;
};

// No wall lies on a multiple of the cell, but for the back one.
inline const std::vector<Wall> kRoom = {{Vector3d::UnitZ(), 0},
                                        {-Vector3d::UnitX(), -1.5},
                                        {Vector3d::UnitY(), -1.02},
                                        {-Vector3d::UnitY(), -1.33},
                                        {Vector3d(1, 0.2, 0).normalized(), -1.2}};
inline const std::vector<Wall> kCorridor = {
    {Vector3d::UnitZ(), 0}, {Vector3d::UnitY(), -1.02}, {-Vector3d::UnitY(), -1.33}};

/// A LiDAR's revolution among walls: rays all round, noise along the ray.
inline std::vector<ScanPoint> Look(const std::vector<Wall>& walls, const Isometry3d& X_WS,
                                   int count, double sigma_m, Rng& rng) {
  std::vector<ScanPoint> scan;
  for (int i = 0; i < count; ++i) {
    const double azimuth = rng.Uniform(-M_PI, M_PI);
    const double z = rng.Uniform(-0.4, 0.4);
    const Vector3d ray_S(std::sqrt(1 - z * z) * std::cos(azimuth),
                         std::sqrt(1 - z * z) * std::sin(azimuth), z);
    const Vector3d ray_W = X_WS.linear() * ray_S;
    double range = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls) {
      const double towards = -wall.n.dot(ray_W);
      if (towards > 1e-9) {
        range = std::min(range, (wall.n.dot(X_WS.translation()) - wall.d) / towards);
      }
    }
    if (range < 4) {
      const double read = range + sigma_m * rng.Normal();
      scan.push_back({(read * ray_S).cast<float>(), static_cast<float>(sigma_m)});
    }
  }
  return scan;
}

/// The sensor on the base, tilted.
inline Isometry3d Mount() {
  Isometry3d X_BS = Isometry3d::Identity();
  X_BS.linear() = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 0.5).normalized()).toRotationMatrix();
  X_BS.translation() << 0.2, -0.1, 0.6;
  return X_BS;
}

inline void Fill(SurfelMap& map, const std::vector<Wall>& walls, const Vector3d& pose,
                 double sigma_m, Rng& rng) {
  const Isometry3d X_WS = BaseAt(pose) * Mount();
  for (const ScanPoint& point : Look(walls, X_WS, 120000, sigma_m, rng)) {
    (void)map.Add(X_WS * point.p_SQ.cast<double>(), point.sigma_m, X_WS.translation());
  }
}

}  // namespace pipewright::test
