// SPDX-License-Identifier: MIT
#pragma once

#include "platform/core/frames.h"

namespace pipewright::hil {

/// What a convex shape is, in its own frame G, centred at G's origin.
enum class ShapeKind : unsigned char {
  kBox,       ///< size_m: the three edge lengths
  kCylinder,  ///< size_m: radius, length, unused; axis z_G
  kSphere,    ///< size_m: radius, unused, unused
  kTriangle,  ///< corners_G; used for the faces of a mesh
};

/// A convex solid in its own frame G [m].
struct Shape {
  ShapeKind kind = ShapeKind::kBox;
  Vector3d size_m = Vector3d::Zero();
  Vector3d corners_G[3] = {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};  ///< kTriangle

  static Shape Box(const Vector3d& size_m) { return Of(ShapeKind::kBox, size_m); }
  static Shape Cylinder(double radius_m, double length_m) {
    return Of(ShapeKind::kCylinder, {radius_m, length_m, 0});
  }
  static Shape Sphere(double radius_m) { return Of(ShapeKind::kSphere, {radius_m, 0, 0}); }
  static Shape Triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    return {ShapeKind::kTriangle, Vector3d::Zero(), {a, b, c}};
  }

  static Shape Of(ShapeKind kind, const Vector3d& size_m) {
    Shape shape;
    shape.kind = kind;
    shape.size_m = size_m;
    return shape;
  }
};

/// The point of the shape that is farthest along d_G (need not be a unit vector), in G.
Vector3d Support(const Shape& shape, const Vector3d& d_G);

/// Radius of the smallest sphere about G's origin that holds the shape [m].
double BoundingRadius(const Shape& shape);

/// Distance of a point to a box, cylinder or sphere [m]; negative inside (to the nearest face).
double SignedDistance(const Shape& shape, const Vector3d& p_G);

}  // namespace pipewright::hil
