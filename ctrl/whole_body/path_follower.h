// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/whole_body/config.h"
#include "plan/goal.h"
#include "platform/robot/model.h"

namespace pipewright {

/// A configuration that moves along Goal::path within the operating limits, and waits for the
/// robot.
///
/// Each edge is up to three pieces (turn, drive, turn), each with constant direction in u. A piece
/// is run from rest to rest by a trapezoid of speed; the reference slows down in proportion as the
/// robot lags behind and stops when it lags by lag_stop.
class PathFollower {
 public:
  PathFollower(const FollowerConfig& config, const RobotModel<kArmJoints>& model, double period_s);

  /// Starts at the robot's own configuration q: the first edge leads from q to path[0].
  void Start(const Configuration& q, const FixedVector<Configuration, Goal::kMaxWaypoints>& path);

  struct Reference {
    Configuration q = Configuration::Zero();
    Controls u = Controls::Zero();    ///< its velocity
    Controls u_n = Controls::Zero();  ///< u plus the feedback that brings the robot to it
  };
  /// Moves the reference on by one period, as far as the lag of the robot at q allows.
  Reference Step(const Configuration& q);

  bool at_end() const;
  double way() const;  ///< pieces done, and the part of the present one

 private:
  bool NextPiece();

  FollowerConfig config_;
  double period_s_;
  Controls speed_;
  Controls acceleration_;
  FixedVector<Configuration, Goal::kMaxWaypoints + 1> waypoints_;
  int edge_ = 0;
  int pieces_done_ = 0;
  double s_ = 0;       ///< part of the piece that is done
  double s_rate_ = 0;  ///< 1/s
  Configuration from_ = Configuration::Zero();
  Controls move_ = Controls::Zero();  ///< the piece: the integral of u over it
};

}  // namespace pipewright
