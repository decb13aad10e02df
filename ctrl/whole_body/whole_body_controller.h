// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/constraints/constraint_set.h"
#include "ctrl/whole_body/chance_qp.h"
#include "ctrl/whole_body/config.h"
#include "ctrl/whole_body/path_follower.h"
#include "plan/goal.h"

namespace pipewright {

struct ControlInput {
  RobotState state;
  const Scene& scene;
  const DistanceField& field;
  const Goal& goal;
};

/// What one cycle did; sums are the caller's.
struct ControlStats {
  int rows = 0;  ///< of the QP, cuts included
  int chance_rows = 0;
  int dropped_rows = 0;
  int clamped_rows = 0;
  int points_inside = 0;
  ChanceQpStats qp;
  double min_plane_m = 0;  ///< estimated clearances, +inf: none
  double min_pipe_m = 0;
  double min_self_m = 0;
  double min_obstacle_m = 0;
};

struct ControlOutput {
  Controls u = Controls::Zero();
  GoalProgress progress;
  ControlStats stats;
};

/// Law (3) of the CFNBV paper on the reduced controls:
///
///   minimise  ‖J u + κ x~ − x_r'‖² + λ_c ‖u − u_n‖² + λ_s ‖s‖²    over the rows of ConstraintSet
///   x = [p_WS; z_WS],  x~ = x − x_d,  J 6×9
///
/// Without a path x_d is the goal's and x_r' = u_n = 0: the published law. With one, x_d and its
/// velocity x_r' are those of a reference that PathFollower moves, and u_n holds the posture.
/// No goal, or a state that is not valid: u = 0.
class WholeBodyController {
 public:
  /// kOutOfRange when the configuration is not valid; the controller then only ever says u = 0.
  WholeBodyController(const WholeBodyConfig& config, const RobotModel<kArmJoints>& model);
  Status status() const { return status_; }

  ControlOutput Step(const ControlInput& input, Time now);

 private:
  struct Task;
  void TakeGoal(const Goal& goal, const Configuration& q, Time now);
  GoalProgress Progress(double error, Time now);

  WholeBodyConfig config_;
  const RobotModel<kArmJoints>& model_;
  Status status_;
  ConstraintBuilder builder_;
  ConstraintSet constraints_;
  ChanceQp qp_;
  PathFollower follower_;
  Controls u_sent_ = Controls::Zero();
  std::uint32_t goal_id_ = 0;
  bool settling_ = false;
  double watched_error_ = 0;
  double watched_way_ = 0;
  Time changed_{};
};

}  // namespace pipewright
