// SPDX-License-Identifier: MIT
#include "plan/cfnbv/open_rays.h"

#include <gtest/gtest.h>

#include "platform/robot/kinematics.h"
#include "platform/robot/shapes.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

using Body = Kinematics<kArmJoints>;

/// Depth below the nearest face of any part but the tool; negative outside all. [m]
double DepthInRobot(const Body& body, const Vector3d& p_W) {
  double depth_m = -1e9;
  for (const BodyShape& shape : TracerUf7Shapes().shapes) {
    if (shape.body != Body::kTool) {
      const Vector3d p_G = (body.X_WL(shape.body) * shape.X_LG).inverse() * p_W;
      depth_m = std::max(depth_m, (shape.half_m - p_G.cwiseAbs()).minCoeff());
    }
  }
  return depth_m;
}

/// The deepest that a ray comes, by steps of 2 mm.
double DeepestAlong(const Body& body, const Vector3d& d_S) {
  double depth_m = -1e9;
  for (double s_m = 0; s_m < 2; s_m += 0.002) {
    depth_m = std::max(depth_m, DepthInRobot(body, body.X_WS() * (s_m * d_S)));
  }
  return depth_m;
}

Configuration Stretched() {
  Configuration q = Configuration::Zero();
  q.tail<kArmJoints>() << 0, 0.4, 0, 1.0, 0, -0.6, 0;
  return q;
}

TEST(OpenRays, AreThoseThatMarchPastTheRobot) {
  constexpr double kStep_m = 0.002;  // what marching may miss at an edge
  GainConfig config;
  config.rays = 60;
  const RaySet camera = LatticeCameraRays(config);
  Rng rng(7);
  int blocked = 0;
  int open_count = 0;
  for (int i = 0; i < 60; ++i) {
    Configuration q = Configuration::Zero();
    for (int j = 0; j < kArmJoints; ++j) {
      const ArmJoint& joint = TracerUf7().arm.joints[j];
      q(3 + j) = rng.Uniform(std::max(joint.q_min_rad, -3.1), std::min(joint.q_max_rad, 3.1));
    }
    q.head<3>() << rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-3, 3);
    const Body body(TracerUf7(), q);
    RaySet open;
    OpenRays(q, camera, open);
    int next = 0;
    for (const Vector3d& d_S : camera.directions) {
      const bool is_open = next < open.directions.size() && open.directions[next] == d_S;
      next += is_open ? 1 : 0;
      const double depth_m = DeepestAlong(body, d_S);
      if (is_open) {
        EXPECT_LT(depth_m, kStep_m);
      } else {
        EXPECT_GT(depth_m, -kStep_m);
      }
      blocked += is_open ? 0 : 1;
      open_count += is_open ? 1 : 0;
    }
    EXPECT_EQ(next, open.directions.size());  // in the camera's order, and no others
  }
  EXPECT_GT(blocked, 300);
  EXPECT_GT(open_count, 300);
}

TEST(OpenRays, AreAllOfThemFromAnArmStretchedAhead) {
  const RaySet camera = LatticeCameraRays({});
  RaySet open;
  OpenRays(Stretched(), camera, open);
  EXPECT_EQ(open.directions.size(), camera.directions.size());
}

}  // namespace
}  // namespace pipewright
