// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/whole_body/config.h"
#include "plan/goal.h"
#include "plan/motion/edge.h"
#include "platform/robot/model.h"

namespace pipewright {

/// A configuration that moves along Goal::path within the operating limits, and waits for the
/// robot.
///
/// Each edge is up to three pieces (turn, drive, turn), on each of which du/ds is constant. A piece
/// is run from rest to rest, its speed a trapezoid; the reference slows down in proportion as the
/// robot lags behind, and stops when it lags by lag_stop.
class PathFollower {
 public:
  using Path = FixedVector<Configuration, Goal::kMaxWaypoints>;

  PathFollower(const FollowerConfig& config, const RobotModel<kArmJoints>& model, double period_s);

  /// Starts on path[0] when the base of the robot at q is about there, else on the way to it.
  /// The path is copied and not empty.
  void Start(const Configuration& q, const Path& path);

  struct Reference {
    Configuration q = Configuration::Zero();
    Controls u = Controls::Zero();    ///< its velocity
    Controls u_n = Controls::Zero();  ///< u plus the feedback that brings the robot to it
  };
  /// Moves the reference on by one period, as far as the lag of the robot at q allows.
  Reference Step(const Configuration& q);

  bool at_end() const { return next_ == path_.size() && s_ >= 1; }
  /// Waypoints passed, and the part of the present edge: grows as the reference moves.
  double way() const { return next_ + s_; }

 private:
  void NextPiece();
  double LagFactor(const Configuration& q) const;
  Controls Feedback(const Configuration& q, const Controls& u_ref) const;

  FollowerConfig config_;
  double period_s_;
  EdgeSpeeds edge_speeds_;
  Controls speed_;
  Controls acceleration_;
  Path path_;
  int next_ = 0;  ///< waypoint after the one that the present edge leads to
  Edge edge_;
  double s_ = 1;      ///< part of the edge that is done
  double s_end_ = 1;  ///< end of the piece
  double s_rate_1ps_ = 0;
  Controls du_ds_ = Controls::Zero();
  Configuration q_ref_ = Configuration::Zero();
};

}  // namespace pipewright
