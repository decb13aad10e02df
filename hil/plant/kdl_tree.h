// SPDX-License-Identifier: MIT
#pragma once

#include <kdl/tree.hpp>

#include "hil/plant/robot_description.h"

namespace pipewright::hil {

/// The description as Orocos KDL's tree: one segment a joint, named as its child link; the root
/// segment is named as the root link. A segment's pose(q) is X_parent_child(q).
KDL::Tree ToKdlTree(const RobotDescription& description);

}  // namespace pipewright::hil
