// SPDX-License-Identifier: MIT
#include "hil/world/shape.h"

#include <algorithm>
#include <cmath>

namespace pipewright::hil {
namespace {

/// Distance from a point to the set {|a| <= half_a, |b| <= half_b} in the half-plane of its two
/// signed excesses; negative inside. The finite cylinder in (rho, z).
double RectangleDistance(double excess_a, double excess_b) {
  const double outside_a = std::max(excess_a, 0.0);
  const double outside_b = std::max(excess_b, 0.0);
  const double outside = std::sqrt(outside_a * outside_a + outside_b * outside_b);
  return outside + std::min(std::max(excess_a, excess_b), 0.0);
}

Vector3d CylinderSupport(const Shape& shape, const Vector3d& d_G) {
  const double radial = std::sqrt(d_G.x() * d_G.x() + d_G.y() * d_G.y());
  const double scale = radial > 0 ? shape.size_m.x() / radial : 0;
  return {scale * d_G.x(), scale * d_G.y(), std::copysign(shape.size_m.y() / 2, d_G.z())};
}

}  // namespace

Vector3d Support(const Shape& shape, const Vector3d& d_G) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return {std::copysign(shape.size_m.x() / 2, d_G.x()),
              std::copysign(shape.size_m.y() / 2, d_G.y()),
              std::copysign(shape.size_m.z() / 2, d_G.z())};
    case ShapeKind::kCylinder:
      return CylinderSupport(shape, d_G);
    case ShapeKind::kSphere: {
      const double norm = d_G.norm();
      return norm > 0 ? Vector3d(d_G * (shape.size_m.x() / norm)) : Vector3d::Zero();
    }
    case ShapeKind::kTriangle: {
      const double along[3] = {shape.corners_G[0].dot(d_G), shape.corners_G[1].dot(d_G),
                               shape.corners_G[2].dot(d_G)};
      return shape.corners_G[std::max_element(along, along + 3) - along];
    }
  }
  return Vector3d::Zero();
}

double BoundingRadius(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return shape.size_m.norm() / 2;
    case ShapeKind::kCylinder:
      return Vector3d(shape.size_m.x(), shape.size_m.y() / 2, 0).norm();
    case ShapeKind::kSphere:
      return shape.size_m.x();
    case ShapeKind::kTriangle:
      return std::max(
          {shape.corners_G[0].norm(), shape.corners_G[1].norm(), shape.corners_G[2].norm()});
  }
  return 0;
}

double SignedDistance(const Shape& shape, const Vector3d& p_G) {
  switch (shape.kind) {
    case ShapeKind::kBox: {
      const Vector3d excess = p_G.cwiseAbs() - shape.size_m / 2;
      return excess.cwiseMax(0).norm() + std::min(excess.maxCoeff(), 0.0);
    }
    case ShapeKind::kCylinder:
      return RectangleDistance(p_G.head<2>().norm() - shape.size_m.x(),
                               std::abs(p_G.z()) - shape.size_m.y() / 2);
    case ShapeKind::kSphere:
      return p_G.norm() - shape.size_m.x();
    case ShapeKind::kTriangle:
      break;
  }
  return 0;
}

}  // namespace pipewright::hil
