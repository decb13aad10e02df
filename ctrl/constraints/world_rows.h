// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/constraints/row_maker.h"

namespace pipewright {

/// What all rows of a cycle are made from.
struct RowContext {
  const ConstraintConfig& config;
  const Kinematics<kArmJoints>& kinematics;
  const RobotShapes& shapes;
  const Controls& u_sent;
  Controls u_max;                                 ///< bound of |u| in the period to come
  const StateCovariance* covariance_q = nullptr;  ///< null: q is known
};

/// Every ball of the arm and tool against planes, pipes and obstacle voxels; the base's centre
/// against near-vertical planes, its discs against obstacle columns.
void AddWorldRows(const RowContext& context, const Scene& scene, const DistanceField& field,
                  RowMaker& maker, Clearances& clearance);

}  // namespace pipewright
