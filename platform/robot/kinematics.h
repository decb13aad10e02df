// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cassert>

#include "platform/core/frames.h"
#include "platform/robot/model.h"

namespace pipewright {

/// Where every body of the robot is at one configuration, and how it moves with the controls.
///
///   q = [x, y, phi, q1 ... qk]        m, rad          3 + k
///   u = [v, omega, q1' ... qk']       m/s, rad/s      2 + k
///
/// Bodies: 0 the base platform (its L is B), 1 ... k the arm's links (modified DH), k + 1 the tool
/// (its L is the flange F = link k). A Jacobian J maps u to a velocity in W: v_WQ = J u. The base's
/// lateral speed has no column: it is zero.
///
/// No heap. Construction costs k sines and cosines; a Jacobian one cross product a column.
template <int kJoints>
class Kinematics {
 public:
  static constexpr int kBase = 0;
  static constexpr int kFlange = kJoints;
  static constexpr int kTool = kJoints + 1;
  static constexpr int kBodies = kJoints + 2;
  static constexpr int kDof = 3 + kJoints;
  static constexpr int kControls = 2 + kJoints;
  using PointJacobianMatrix = Mat<3, kControls>;

  /// Computes all poses. The model must outlive this.
  Kinematics(const RobotModel<kJoints>& robot, const Vec<kDof>& q);

  /// Pose of a body's frame L.
  const Isometry3d& X_WL(int body) const {
    assert(0 <= body && body < kBodies);
    return X_WL_[body];
  }
  Isometry3d X_WS() const;
  Vector3d p_WS() const;
  Vector3d z_WS() const { return X_WL_[kTool].linear().col(2); }
  Vector3d p_WP() const;

  /// p_WQ of the point Q that is fixed in a body at p_LQ.
  Vector3d Point(int body, const Vector3d& p_LQ) const { return X_WL(body) * p_LQ; }

  /// J with v_WQ = J u, for the point Q fixed in a body at p_LQ. Row units m/s per unit of u.
  PointJacobianMatrix PointJacobian(int body, const Vector3d& p_LQ) const;

  /// The same for a point already known in W.
  PointJacobianMatrix PointJacobianAt(int body, const Vector3d& p_WQ) const;

  /// n' J without J: the row that maps u to the speed of Q along n_W. For one-sided constraints.
  Eigen::Matrix<double, 1, kControls> PointRow(int body, const Vector3d& p_WQ,
                                               const Vector3d& n_W) const;

  /// J with d/dt l_W = J u, for an axis fixed in a body along l_L (|l| = 1). 1/s per unit of u.
  PointJacobianMatrix AxisJacobian(int body, const Vector3d& l_L) const;

  /// J with d/dt [l_W; m_W] = J u: the Pluecker line through Q along l, m = p_WQ x l_W.
  Mat<6, kControls> LineJacobian(int body, const Vector3d& p_LQ, const Vector3d& l_L) const;

  /// [J_t; J_n] of law (3): rows 0-2 the sensor's position, rows 3-5 its axis z_WS.
  Mat<6, kControls> SensorJacobian() const;

 private:
  const RobotModel<kJoints>& robot_;
  std::array<Isometry3d, kBodies> X_WL_;
};

extern template class Kinematics<6>;
extern template class Kinematics<7>;

}  // namespace pipewright
