// SPDX-License-Identifier: MIT
#include "platform/robot/kinematics.h"

#include <cmath>

namespace pipewright {
namespace {

Vector3d ToVector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

struct SinCos {
  double s = 0;
  double c = 1;
};

constexpr SinCos OfQuarterTurns(int quarters) {
  switch (quarters & 3) {
    case 1:
      return {1, 0};
    case 2:
      return {0, -1};
    case 3:
      return {-1, 0};
    default:
      return {0, 1};
  }
}

Isometry3d TurnAboutZ(const Vector3d& p, double angle_rad) {
  const double s = std::sin(angle_rad);
  const double c = std::cos(angle_rad);
  Isometry3d X = Isometry3d::Identity();
  X.linear() << c, -s, 0, s, c, 0, 0, 0, 1;
  X.translation() = p;
  return X;
}

/// X Rx(alpha) Tx(a) Rz(q) Tz(d), column by column.
Isometry3d Next(const Isometry3d& X, const ArmJoint& joint, double q) {
  const SinCos alpha = OfQuarterTurns(joint.alpha_quarter_turns);
  const double s = std::sin(q);
  const double c = std::cos(q);
  const Vector3d x = X.linear().col(0);
  const Vector3d y = alpha.c * X.linear().col(1) + alpha.s * X.linear().col(2);
  const Vector3d z = alpha.c * X.linear().col(2) - alpha.s * X.linear().col(1);
  Isometry3d next = Isometry3d::Identity();
  next.linear().col(0) = c * x + s * y;
  next.linear().col(1) = c * y - s * x;
  next.linear().col(2) = z;
  next.translation() = X.translation() + joint.a_m * x + joint.d_m * z;
  return next;
}

}  // namespace

template <int kJoints>
Kinematics<kJoints>::Kinematics(const RobotModel<kJoints>& robot, const Vec<kDof>& q)
    : robot_(robot) {
  X_WL_[kBase] = TurnAboutZ({q(0), q(1), 0}, q(2));
  Isometry3d X = X_WL_[kBase] * TurnAboutZ(ToVector(robot.mount.p_BA_m), robot.mount.yaw_rad);
  for (int i = 0; i < kJoints; ++i) {
    X = Next(X, robot.arm.joints[i], q(3 + i));
    X_WL_[1 + i] = X;
  }
  X_WL_[kTool] = X;
}

template <int kJoints>
Isometry3d Kinematics<kJoints>::X_WS() const {
  Isometry3d X = X_WL_[kTool];
  X.translation() = p_WS();
  return X;
}

template <int kJoints>
Vector3d Kinematics<kJoints>::p_WS() const {
  return X_WL_[kTool] * ToVector(robot_.tool.p_FS_m);
}

template <int kJoints>
Vector3d Kinematics<kJoints>::p_WP() const {
  return X_WL_[kTool] * ToVector(robot_.tool.p_FP_m);
}

template <int kJoints>
auto Kinematics<kJoints>::PointJacobian(int body, const Vector3d& p_LQ) const
    -> PointJacobianMatrix {
  return PointJacobianAt(body, Point(body, p_LQ));
}

template <int kJoints>
auto Kinematics<kJoints>::PointJacobianAt(int body, const Vector3d& p_WQ) const
    -> PointJacobianMatrix {
  PointJacobianMatrix J = PointJacobianMatrix::Zero();
  const Vector3d p_BQ_W = p_WQ - X_WL_[kBase].translation();
  J.col(0) = X_WL_[kBase].linear().col(0);
  J.col(1) << -p_BQ_W.y(), p_BQ_W.x(), 0;
  for (int i = 1; i <= kJoints && i <= body; ++i) {
    const Isometry3d& X = X_WL_[i];
    J.col(1 + i) = X.linear().col(2).cross(p_WQ - X.translation());
  }
  return J;
}

template <int kJoints>
auto Kinematics<kJoints>::PointRow(int body, const Vector3d& p_WQ, const Vector3d& n_W) const
    -> Eigen::Matrix<double, 1, kControls> {
  Eigen::Matrix<double, 1, kControls> row = Eigen::Matrix<double, 1, kControls>::Zero();
  const Vector3d p_BQ_W = p_WQ - X_WL_[kBase].translation();
  row(0) = n_W.dot(X_WL_[kBase].linear().col(0));
  row(1) = p_BQ_W.x() * n_W.y() - p_BQ_W.y() * n_W.x();
  const Vector3d m_W = p_WQ.cross(n_W);
  for (int i = 1; i <= kJoints && i <= body; ++i) {
    // n . (z x (p - o)) = z . ((p - o) x n)
    const Isometry3d& X = X_WL_[i];
    row(1 + i) = X.linear().col(2).dot(m_W - X.translation().cross(n_W));
  }
  return row;
}

template <int kJoints>
auto Kinematics<kJoints>::AxisJacobian(int body, const Vector3d& l_L) const -> PointJacobianMatrix {
  PointJacobianMatrix J = PointJacobianMatrix::Zero();
  const Vector3d l_W = X_WL(body).linear() * l_L;
  J.col(1) << -l_W.y(), l_W.x(), 0;
  for (int i = 1; i <= kJoints && i <= body; ++i) {
    J.col(1 + i) = X_WL_[i].linear().col(2).cross(l_W);
  }
  return J;
}

template <int kJoints>
auto Kinematics<kJoints>::LineJacobian(int body, const Vector3d& p_LQ, const Vector3d& l_L) const
    -> Mat<6, kControls> {
  const Vector3d p_WQ = Point(body, p_LQ);
  const Vector3d l_W = X_WL(body).linear() * l_L;
  const PointJacobianMatrix J_p = PointJacobianAt(body, p_WQ);
  const PointJacobianMatrix J_l = AxisJacobian(body, l_L);
  Mat<6, kControls> J;
  for (int i = 0; i < kControls; ++i) {
    J.template block<3, 1>(0, i) = J_l.col(i);
    J.template block<3, 1>(3, i) = J_p.col(i).cross(l_W) + p_WQ.cross(J_l.col(i));
  }
  return J;
}

template <int kJoints>
auto Kinematics<kJoints>::SensorJacobian() const -> Mat<6, kControls> {
  Mat<6, kControls> J;
  J.template topRows<3>() = PointJacobianAt(kTool, p_WS());
  J.template bottomRows<3>() = AxisJacobian(kTool, Vector3d::UnitZ());
  return J;
}

template class Kinematics<6>;
template class Kinematics<7>;

}  // namespace pipewright
