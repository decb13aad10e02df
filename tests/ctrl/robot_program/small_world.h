// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "ctrl/robot_program/robot_program.h"
#include "hil/plant/plant.h"
#include "hil/plant/robot_description.h"
#include "hil/sensors/depth_camera.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/uf7.h"

namespace pipewright::test {

inline hil::Solid Box(const char* name, const Vector3d& center_m, const Vector3d& size_m) {
  hil::Solid solid;
  solid.kind = hil::SolidKind::kBox;
  solid.name = name;
  solid.X_WG = Eigen::Translation3d(center_m) * Isometry3d::Identity();
  solid.shape = hil::Shape::Box(size_m);
  return solid;
}

/// A floor, a wall and an upright pipe, all in front of a robot at the origin.
inline std::vector<hil::Solid> WallAndPipe() {
  hil::Solid floor;
  floor.kind = hil::SolidKind::kPlane;
  floor.name = "floor";
  floor.ground = true;
  hil::Solid pipe;
  pipe.kind = hil::SolidKind::kCylinder;
  pipe.name = "pipe";
  pipe.X_WG = Eigen::Translation3d(1.3, 0.3, 0.75) * Isometry3d::Identity();
  pipe.shape = hil::Shape::Cylinder(0.08, 1.5);
  return {floor, Box("wall", {1.825, 0, 0.75}, {0.05, 3, 1.5}), pipe};
}

/// 3 m to each side of the robot, of which the metre ahead is to be inspected.
inline MapConfig SmallMap() {
  MapConfig map;
  map.lo = {-20, -30, -2};
  map.hi = {43, 29, 39};
  map.workspace_lo = {14, -14, 2};
  map.workspace_hi = {33, 13, 25};
  map.brick_capacity = BricksOfBox(map);
  return map;
}

inline Configuration HomeAtOrigin() {
  Configuration q = Configuration::Zero();
  q.tail<kArmJoints>() = HomeJoints(TracerUf7());
  return q;
}

/// A history in which the robot moves from `from` to `to` within 0.1 s, both of them valid.
inline StateHistory Moving(const Configuration& from, const Configuration& to, Time start) {
  StateHistory history;
  RobotState state;
  state.valid = true;
  state.stamp = start;
  state.q = from;
  history.Add(state);
  state.stamp = start + std::chrono::milliseconds(100);
  state.q = to;
  history.Add(state);
  return history;
}

}  // namespace pipewright::test
