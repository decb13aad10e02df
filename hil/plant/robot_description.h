// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "platform/core/frames.h"

/// What a URDF says of a robot: links, joints, collision shapes. Visuals and inertias are not read.
namespace pipewright::hil {

/// One collision body, rigid in its link. G is the shape's own frame: its centre; a cylinder's axis
/// is z_G.
struct CollisionShape {
  enum class Kind { kBox, kCylinder, kSphere, kMesh };

  std::string link;
  std::string name;  ///< the collision element's name; may be empty
  Kind kind = Kind::kBox;
  /// Box: full side lengths. Cylinder: (radius, radius, length). Sphere: (radius, radius, radius).
  /// Mesh: scale along x, y, z (the only kind whose size has no unit).
  Vector3d size_m = Vector3d::Zero();
  std::string mesh_file;  ///< as written in the URDF; mesh only
  Isometry3d X_LG = Isometry3d::Identity();
};

/// A joint as URDF defines it: X_parent_child(q) = X_PJ * motion(axis, q).
struct JointDescription {
  enum class Kind { kFixed, kRevolute, kContinuous, kPrismatic };

  std::string name;
  Kind kind = Kind::kFixed;
  std::string parent;
  std::string child;
  Isometry3d X_PJ = Isometry3d::Identity();
  Vector3d axis_J = Vector3d::UnitX();  ///< unit length
  double lower = 0;                     ///< rad, or m when prismatic; ±infinity when continuous
  double upper = 0;
  double velocity_max = 0;  ///< rad/s or m/s
  double effort_max = 0;    ///< N m or N
};

/// A tree of links. links[0] is the root; joints and links are sorted so that a joint's parent
/// comes before its child.
struct RobotDescription {
  std::string name;
  std::vector<std::string> links;
  std::vector<JointDescription> joints;  ///< joints[i] moves links[i + 1]
  std::vector<CollisionShape> shapes;    ///< in the order of the file

  /// -1: no such link.
  int LinkIndex(std::string_view link) const;
  /// The joints that move, root first.
  std::vector<const JointDescription*> MovingJoints() const;
};

/// Where a URDF is wrong. Text() is "file:line: <element>: what".
struct DescriptionError {
  std::string file;
  int line = 0;
  std::string element;
  std::string what;

  std::string Text() const;
};

/// Reads a URDF. `file` is only its name, for messages.
///
/// Refused, with the place: broken XML; a root that is not <robot>; a missing or non-numeric
/// attribute; a size that is not positive; a moving joint without <limit>; two links or joints of
/// one name; a joint of an unknown link; a link with two parents; no root or more than one; a loop.
std::optional<RobotDescription> ParseUrdf(std::string_view text, const std::string& file,
                                          DescriptionError& error);

/// The URDF of the Tracer with UF7, camera and probe, held in the binary. Its links: base_link (B),
/// arm_base (A), link1 ... link7, tool (F), camera (S), probe (P).
std::string_view TracerUf7Urdf();

/// TracerUf7Urdf(), read.
RobotDescription TracerUf7Description();

}  // namespace pipewright::hil
