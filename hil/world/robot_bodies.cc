// SPDX-License-Identifier: MIT
#include "hil/world/robot_bodies.h"

#include <cassert>

#include "hil/plant/robot_description.h"

namespace pipewright::hil {
namespace {

Shape ShapeOf(const CollisionShape& from) {
  switch (from.kind) {
    case CollisionShape::Kind::kBox:
      return Shape::Box(from.size_m);
    case CollisionShape::Kind::kCylinder:
      return Shape::Cylinder(from.size_m.x(), from.size_m.z());
    case CollisionShape::Kind::kSphere:
      return Shape::Sphere(from.size_m.x());
    case CollisionShape::Kind::kMesh:
      break;
  }
  assert(false && "a robot's bodies are convex primitives");
  return Shape::Sphere(0);
}

bool Moves(const JointDescription& joint) { return joint.kind != JointDescription::Kind::kFixed; }

Isometry3d Motion(const JointDescription& joint, double q) {
  Isometry3d X_JC = Isometry3d::Identity();
  if (joint.kind == JointDescription::Kind::kPrismatic) {
    X_JC.translation() = joint.axis_J * q;
  } else if (Moves(joint)) {
    X_JC.linear() = Eigen::AngleAxisd(q, joint.axis_J).toRotationMatrix();
  }
  return X_JC;
}

}  // namespace

RobotBodies RobotBodiesOf(const RobotDescription& description) {
  RobotBodies model;
  model.links = static_cast<int>(description.links.size());
  const int probe = description.LinkIndex("probe");
  assert(probe >= 0);

  std::vector<int> parent(description.joints.size());
  std::vector<int> group(description.links.size(), 0);
  int groups = 1;
  for (std::size_t i = 0; i < description.joints.size(); ++i) {
    const JointDescription& joint = description.joints[i];
    parent[i] = description.LinkIndex(joint.parent);
    group[i + 1] = group[parent[i]];
    if (Moves(joint)) {
      model.adjacent_groups.emplace_back(group[parent[i]], groups);
      group[i + 1] = groups++;
      model.joint_min_rad.push_back(joint.lower);
      model.joint_max_rad.push_back(joint.upper);
    }
  }
  for (const CollisionShape& shape : description.shapes) {
    const int link = description.LinkIndex(shape.link);
    const std::string name = shape.name.empty() ? shape.link : shape.link + "/" + shape.name;
    model.bodies.push_back({name, link, group[link], ShapeOf(shape), shape.X_LG});
  }
  model.forward = [joints = description.joints, parent, probe](
                      double x_m, double y_m, double yaw_rad, std::span<const double> joints_rad,
                      RobotBodies::Pose& pose) {
    pose.X_WL.resize(joints.size() + 1);
    pose.X_WL[0] =
        Eigen::Translation3d(x_m, y_m, 0) * Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ());
    std::size_t next = 0;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const double q = Moves(joints[i]) ? joints_rad[next++] : 0;
      pose.X_WL[i + 1] = pose.X_WL[parent[i]] * joints[i].X_PJ * Motion(joints[i], q);
    }
    pose.p_WP = pose.X_WL[probe].translation();
  };
  return model;
}

}  // namespace pipewright::hil
