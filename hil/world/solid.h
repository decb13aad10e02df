// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "hil/world/mesh.h"
#include "hil/world/shape.h"

namespace pipewright::hil {

enum class SolidKind : unsigned char {
  kPlane,  ///< a half-space: free where z_G > 0
  kBox,
  kCylinder,  ///< finite, capped
  kMesh,      ///< vertices are in W already; X_WG is the identity
};

/// One thing of the world.
struct Solid {
  SolidKind kind = SolidKind::kBox;
  std::string name;
  bool ground = false;  ///< a plane the base stands on: its nearness to the base is no danger
  Isometry3d X_WG = Isometry3d::Identity();
  Shape shape;                       ///< box, cylinder
  std::shared_ptr<const Mesh> mesh;  ///< mesh
};

/// Clearances are kept apart by what they are kept to: walls and floors (planes, boxes) or pipes
/// (cylinders, meshes).
inline bool IsPipe(const Solid& s) {
  return s.kind == SolidKind::kCylinder || s.kind == SolidKind::kMesh;
}

/// Distance of a point to a solid's surface [m], negative inside (a mesh: 0 inside, when closed).
double Distance(const Solid& solid, const Vector3d& p_W);

/// Distance of a convex shape to a solid [m], 0 on touch or overlap. See ConvexDistance.
double Distance(const Solid& solid, const Shape& shape, const Isometry3d& X_WS,
                double stop_above_m = 1e9);

}  // namespace pipewright::hil
