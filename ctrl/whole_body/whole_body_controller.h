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
  const StateCovariance* covariance_q = nullptr;  ///< of state.q; null: q is known
};

/// What one cycle did; sums are the caller's.
struct ControlStats {
  int rows = 0;  ///< of the QP, cuts included
  int chance_rows = 0;
  int dropped_rows = 0;
  double box_part = 1;    ///< of the box, in which the dropped rows hold
  int clamped_rows = 0;   ///< of pairs that are too near already
  int points_inside = 0;  ///< robot points in obstacle voxels
  ChanceQpStats qp;
  std::int64_t qp_ns = 0;  ///< by config.stopwatch; 0 without one
  Clearances clearance;    ///< as estimated
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
/// velocity x_r' are those of a reference that PathFollower moves, and u_n holds its posture. At
/// the path's end x_d is the goal's, and u_n = −k J'(JJ' + μI)⁻¹ x~: with u_n = 0 the directions in
/// which J is weak close at κσ²/(σ² + λ_c) only, tens of seconds to a millimetre.
/// No goal, or a state that is not valid: u = 0.
class WholeBodyController {
 public:
  /// The model and its shapes must outlive this.
  WholeBodyController(const WholeBodyConfig& config, const RobotModel<kArmJoints>& model,
                      const RobotShapes& shapes);

  /// kOutOfRange when the configuration is not Valid (alpha < 0.5 among others: that constraint is
  /// not convex); then Step only ever says u = 0.
  Status status() const { return status_; }

  /// Call once a period. The answer's u keeps the box and every hard row of constraints().
  ControlOutput Step(const ControlInput& input, Time now);

  /// The envelope sends u in place of the last step's answer: the next step's accelerations count
  /// from it, and the chance rows that hold are counted for it in `stats`.
  void Sent(const Controls& u, ControlStats& stats);

  /// The rows of the last step, for inspection.
  const ConstraintSet& constraints() const { return constraints_; }

 private:
  struct Reference {
    Vec<6> x_d = Vec<6>::Zero();
    Vec<6> v_d = Vec<6>::Zero();  ///< x_d'
    Controls u_n = Controls::Zero();
  };

  std::int64_t StopwatchNow() const {
    return config_.stopwatch == nullptr ? 0 : config_.stopwatch();
  }
  void Take(const Goal& goal, const Configuration& q, Time now);
  Reference MakeReference(const Goal& goal, const Configuration& q, const Mat<6, kControls>& J,
                          const Vec<6>& x, Time now);
  GoalState Watch(double error, Time now);

  WholeBodyConfig config_;
  const RobotModel<kArmJoints>& model_;
  Status status_;
  ConstraintBuilder builder_;
  ConstraintSet constraints_;
  ChanceQp qp_;
  PathFollower follower_;
  Controls u_sent_ = Controls::Zero();

  std::uint32_t goal_id_ = 0;
  bool following_ = false;  ///< the goal has a path that is not done
  bool settling_ = false;   ///< the goal has a path that is done
  bool arrived_ = false;    ///< the reference is at the path's end
  Time arrived_at_{};
  double smooth_error_ = 0;
  double held_error_ = 0;  ///< ‖x − x_d‖ and way when they last changed
  double held_way_ = 0;
  Time changed_at_{};
  double best_error_ = 0;  ///< and when they were last better than ever
  double best_way_ = 0;
  Time better_at_{};
};

}  // namespace pipewright
