// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "plan/gain/gain.h"

namespace pipewright {

Viewpoint UprightViewpoint(const Vector3d& p_WS, const Vector3d& z_WS) {
  Vector3d x_WS = z_WS.cross(Vector3d::UnitZ());
  const double horizontal = x_WS.norm();
  x_WS = horizontal > 1e-9 ? Vector3d(x_WS / horizontal) : Vector3d(-Vector3d::UnitY());
  Viewpoint view;
  view.X_WS.linear().col(0) = x_WS;
  view.X_WS.linear().col(1) = z_WS.cross(x_WS);
  view.X_WS.linear().col(2) = z_WS;
  view.X_WS.translation() = p_WS;
  view.p_WP = p_WS;
  return view;
}

namespace {

/// The direction of image point (x, y) at z = 1.
Vector3d CameraRay(double x, double y) { return Vector3d(x, y, 1).normalized(); }

}  // namespace

RaySet RandomCameraRays(const GainConfig& config, Rng& rng) {
  const double x_max = std::tan(config.fov_x_rad / 2);
  const double y_max = std::tan(config.fov_y_rad / 2);
  RaySet rays;
  bool room = true;
  for (int i = 0; i < config.rays && room; ++i) {
    const double x = rng.Uniform(-x_max, x_max);
    room = rays.directions.push_back(CameraRay(x, rng.Uniform(-y_max, y_max)));
  }
  return rays;
}

RaySet LatticeCameraRays(const GainConfig& config) {
  // A rank-1 lattice (Kronecker's, with the golden ratio): even at every count.
  constexpr double kGolden = 0.6180339887498949;
  const double x_max = std::tan(config.fov_x_rad / 2);
  const double y_max = std::tan(config.fov_y_rad / 2);
  RaySet rays;
  bool room = true;
  for (int i = 0; i < config.rays && room; ++i) {
    const double row = (i + 0.5) / config.rays;
    const double column = kGolden * i - std::floor(kGolden * i);
    room = rays.directions.push_back(CameraRay((2 * column - 1) * x_max, (2 * row - 1) * y_max));
  }
  return rays;
}

RaySet RandomSphereRays(const GainConfig& config, Rng& rng) {
  RaySet rays;
  bool room = true;
  for (int i = 0; i < config.rays && room; ++i) {
    const double z = rng.Uniform(-1, 1);
    const double azimuth = rng.Uniform(-std::numbers::pi, std::numbers::pi);
    const double radius = std::sqrt(1 - z * z);
    room = rays.directions.push_back(
        Vector3d(radius * std::cos(azimuth), radius * std::sin(azimuth), z));
  }
  return rays;
}

}  // namespace pipewright
