// SPDX-License-Identifier: MIT
#include "plan/cfnbv/open_rays.h"

#include <algorithm>
#include <cmath>

#include "platform/robot/kinematics.h"
#include "platform/robot/shapes.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

/// A part of the robot as the sensor has it: axes of G, centred at G.
struct Part {
  Vector3d p_GS;
  Matrix3d R_GS;
  Vector3d half_m;
};

/// The ray from p_G along d_G meets the box, by its three slabs.
bool Meets(const Vector3d& p_G, const Vector3d& d_G, const Vector3d& half_m) {
  double from = 0;
  double to = 1e9;
  for (int i = 0; i < 3; ++i) {
    if (d_G(i) == 0) {
      to = std::abs(p_G(i)) <= half_m(i) ? to : -1;
      continue;
    }
    const double one = (-half_m(i) - p_G(i)) / d_G(i);
    const double other = (half_m(i) - p_G(i)) / d_G(i);
    from = std::max(from, std::min(one, other));
    to = std::min(to, std::max(one, other));
  }
  return from <= to;
}

}  // namespace

void OpenRays(const Configuration& q, const RaySet& camera, RaySet& open) {
  const Kinematics<kArmJoints> body(TracerUf7(), q);
  FixedVector<Part, RobotShapes::kMaxShapes> parts;
  for (const BodyShape& shape : TracerUf7Shapes().shapes) {
    const Isometry3d X_GS = (body.X_WL(shape.body) * shape.X_LG).inverse() * body.X_WS();
    if (shape.body != Kinematics<kArmJoints>::kTool) {
      static_cast<void>(parts.push_back({X_GS.translation(), X_GS.linear(), shape.half_m}));
    }
  }
  open.directions.clear();
  for (const Vector3d& d_S : camera.directions) {
    const bool blocked = std::any_of(parts.begin(), parts.end(), [&](const Part& part) {
      return Meets(part.p_GS, part.R_GS * d_S, part.half_m);
    });
    if (!blocked) {
      static_cast<void>(open.directions.push_back(d_S));
    }
  }
}

}  // namespace pipewright
