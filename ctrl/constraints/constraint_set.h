// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "ctrl/constraints/config.h"
#include "ctrl/constraints/svfi.h"
#include "perception/map/distance_field.h"
#include "perception/scene.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/model.h"
#include "platform/robot/shapes.h"

namespace pipewright {

/// Least estimated distances of the robot's surface, over all pairs that are looked at.
struct Clearances {
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  double plane_m = kNone;
  double pipe_m = kNone;
  double self_m = kNone;
  double obstacle_m = kNone;  ///< to obstacle voxels and columns
};

/// Everything that bounds u in one cycle.
///
/// **u = 0 keeps every hard row and the box**, whatever the robot's place and the estimates: where
/// an estimate says that a distance is already below d_safe, the hard row forbids to come nearer,
/// and a soft row asks to leave at recovery speed at most.
struct ConstraintSet {
  Controls lb = Controls::Zero();
  Controls ub = Controls::Zero();
  /// What of the box the robot can do within one period: braking takes time, too. 0 need not be in
  /// it, nor any u that keeps the rows.
  Controls reach_lb = Controls::Constant(-std::numeric_limits<double>::infinity());
  Controls reach_ub = Controls::Constant(std::numeric_limits<double>::infinity());
  RowSet rows;          ///< deterministic: the robot's own parts and joints
  ChanceRowSet chance;  ///< stochastic: planes, pipes, obstacle voxels and columns
  double z = 0;         ///< Φ⁻¹ of α or, with joint_risk, of each row's share of it

  int dropped = 0;  ///< rows that did not fit; those that bind first are kept
  /// What is left of lb, ub and their reach so that no u of it breaks a dropped row: 1, unless the
  /// rows that the whole box could break are too many.
  double box_part = 1;
  int clamped = 0;  ///< hard rows at d < d_safe (or, by chance, at less than α standing still)
  int inside = 0;   ///< robot points whose centre is in an obstacle voxel
  Clearances clearance;
};

/// Builds the rows for configuration q. Fixed memory, no failure; some 30 µs for 120 rows.
class ConstraintBuilder {
 public:
  /// Valid(config) is required.
  ConstraintBuilder(const ConstraintConfig& config, const RobotModel<kArmJoints>& model,
                    const RobotShapes& shapes);

  /// `u_sent`: the last cycle's control, from which accelerations are limited. `covariance_q`: of
  /// q, for the chance rows; null: q is known. With joint_risk the rows are made twice.
  void Build(const Configuration& q, const Kinematics<kArmJoints>& kinematics,
             const Controls& u_sent, const Scene& scene, const DistanceField& field,
             ConstraintSet& out, const StateCovariance* covariance_q = nullptr) const;

 private:
  ConstraintConfig config_;
  const RobotModel<kArmJoints>& model_;
  const RobotShapes& shapes_;
  double z_ = 0;
};

}  // namespace pipewright
