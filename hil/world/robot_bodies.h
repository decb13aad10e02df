// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "hil/world/shape.h"

namespace pipewright::hil {

struct RobotDescription;

/// One convex body of the robot, fixed in a link.
struct Body {
  std::string name;
  int link = 0;   ///< index into the link poses
  int group = 0;  ///< links that are fixed to each other share one; 0 is the base's
  Shape shape;
  Isometry3d X_LG = Isometry3d::Identity();
};

/// What the ground truth needs to know of a robot.
struct RobotBodies {
  std::vector<Body> bodies;
  /// Groups joined by one joint: their bodies meet at it and are not checked against each other.
  std::vector<std::pair<int, int>> adjacent_groups;
  std::vector<double> joint_min_rad;
  std::vector<double> joint_max_rad;
  int links = 0;

  /// Poses of all links and the probe's centre.
  struct Pose {
    std::vector<Isometry3d> X_WL;  ///< one a link
    Vector3d p_WP = Vector3d::Zero();
  };
  /// Forward kinematics of base pose (x, y, yaw) and joints.
  std::function<void(double x_m, double y_m, double yaw_rad, std::span<const double> joints_rad,
                     Pose& pose)>
      forward;
};

/// The model of a description whose collision shapes are boxes, cylinders and spheres (assert) and
/// that has a link named probe. Link indices are those of RobotDescription::links.
RobotBodies RobotBodiesOf(const RobotDescription& description);

}  // namespace pipewright::hil
