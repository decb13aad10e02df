// SPDX-License-Identifier: MIT
#include "hil/plant/kdl_tree.h"

#include <cassert>

namespace pipewright::hil {
namespace {

KDL::Vector ToKdl(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame ToKdl(const Isometry3d& X) {
  const Matrix3d R = X.linear();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                        R(2, 2)),
          ToKdl(X.translation())};
}

/// KDL gives a joint's origin and axis in the parent's frame.
KDL::Joint ToKdlJoint(const JointDescription& joint) {
  const KDL::Vector origin = ToKdl(joint.X_PJ.translation());
  const KDL::Vector axis = ToKdl(Vector3d(joint.X_PJ.linear() * joint.axis_J));
  switch (joint.kind) {
    case JointDescription::Kind::kFixed:
      return KDL::Joint(joint.name, KDL::Joint::Fixed);
    case JointDescription::Kind::kRevolute:
    case JointDescription::Kind::kContinuous:
      return KDL::Joint(joint.name, origin, axis, KDL::Joint::RotAxis);
    case JointDescription::Kind::kPrismatic:
      return KDL::Joint(joint.name, origin, axis, KDL::Joint::TransAxis);
  }
  return KDL::Joint(joint.name, KDL::Joint::Fixed);
}

}  // namespace

KDL::Tree ToKdlTree(const RobotDescription& description) {
  KDL::Tree tree(description.links[0]);
  for (const JointDescription& joint : description.joints) {
    const bool added = tree.addSegment(
        KDL::Segment(joint.child, ToKdlJoint(joint), ToKdl(joint.X_PJ)), joint.parent);
    assert(added);
    static_cast<void>(added);
  }
  return tree;
}

}  // namespace pipewright::hil
