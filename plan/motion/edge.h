// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "platform/robot/model.h"
#include "platform/robot/robot.h"

namespace pipewright {

/// Operating speeds that share an edge out in time.
struct EdgeSpeeds {
  double drive_mps = 0.4;
  double turn_radps = 1.0;
  ArmVector joint_radps = ArmVector::Ones();
};

EdgeSpeeds SpeedsOf(const RobotModel<kArmJoints>& robot);

/// The way between two configurations of a Goal's path: the base turns on the spot, drives straight
/// (forwards or backwards, whichever turns less) and turns again, at speeds in a fixed ratio; the
/// joints move in proportion. s in [0, 1] is the share of the time done.
///
/// phi runs on from a's, so that it is continuous; at s = 1 it equals b's up to whole turns.
class Edge {
 public:
  Edge(const Configuration& a, const Configuration& b, const EdgeSpeeds& speeds = {});

  /// The configuration at s; s is clamped to [0, 1].
  Configuration At(double s) const;

  /// Drive, turn and joints per unit of s; divided by duration_s() they are the controls u at
  /// operating speed.
  Controls RateAt(double s) const;

  /// Time at operating speeds, without ramps: max of the base's and the slowest joint's.
  double duration_s() const { return duration_s_; }

  double turn_rad() const { return std::abs(turn1_rad_) + std::abs(turn2_rad_); }
  double drive_m() const { return std::abs(drive_m_); }
  /// RateAt is constant on [0, s_turned], [s_turned, s_driven] and [s_driven, 1].
  double s_turned() const { return s_turned_; }
  double s_driven() const { return s_driven_; }
  double joints_rad() const { return joints_.cwiseAbs().maxCoeff(); }

  /// Checks needed so that between two of them the base moves at most drive_step_m or turns at most
  /// turn_step_rad, and no joint turns more than turn_step_rad; at least 1.
  int Steps(double drive_step_m, double turn_step_rad) const;

 private:
  Configuration a_;
  ArmVector joints_;                                   ///< b - a
  Eigen::Vector2d shift_m_ = Eigen::Vector2d::Zero();  ///< what is too short to drive
  double heading_rad_ = 0;                             ///< of the nose while driving
  double turn1_rad_ = 0;
  double drive_m_ = 0;  ///< negative: backwards
  double turn2_rad_ = 0;
  double s_turned_ = 0;  ///< s at the end of the first turn
  double s_driven_ = 0;  ///< s at the end of the drive
  double duration_s_ = 0;
};

Configuration EdgeAt(const Configuration& a, const Configuration& b, double s);

/// The angle's equal in (-pi, pi].
double WrapAngle(double angle_rad);

}  // namespace pipewright
