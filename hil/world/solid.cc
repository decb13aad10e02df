// SPDX-License-Identifier: MIT
#include "hil/world/solid.h"

#include <algorithm>

#include "hil/world/convex_distance.h"

namespace pipewright::hil {

double Distance(const Solid& solid, const Vector3d& p_W) {
  switch (solid.kind) {
    case SolidKind::kPlane:
      return (solid.X_WG.inverse() * p_W).z();
    case SolidKind::kBox:
    case SolidKind::kCylinder:
      return SignedDistance(solid.shape, solid.X_WG.inverse() * p_W);
    case SolidKind::kMesh: {
      Isometry3d X_WS = Isometry3d::Identity();
      X_WS.translation() = p_W;
      return solid.mesh->Distance(Shape::Sphere(0), X_WS, 1e9);
    }
  }
  return 0;
}

double Distance(const Solid& solid, const Shape& shape, const Isometry3d& X_WS,
                double stop_above_m) {
  switch (solid.kind) {
    case SolidKind::kPlane: {
      const Vector3d n_W = solid.X_WG.linear().col(2);
      const Vector3d d_S = -(X_WS.linear().transpose() * n_W);
      return std::max(Distance(solid, X_WS * Support(shape, d_S)), 0.0);
    }
    case SolidKind::kBox:
    case SolidKind::kCylinder:
      return ConvexDistance(solid.shape, solid.X_WG, shape, X_WS, stop_above_m);
    case SolidKind::kMesh:
      return solid.mesh->Distance(shape, X_WS, stop_above_m);
  }
  return 0;
}

}  // namespace pipewright::hil
