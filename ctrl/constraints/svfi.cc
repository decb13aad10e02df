// SPDX-License-Identifier: MIT
#include "ctrl/constraints/svfi.h"

#include <algorithm>
#include <cmath>

#include "platform/core/normal.h"

namespace pipewright {
namespace {

constexpr double kNoDeviation = 1e-12;

/// Q, q and c of VelocityCone for ∇f = K v + h. (Loops: Eigen's 3×k·k×k product could allocate.)
template <int k>
VelocityCone MakeCone(const Mat<k, 3>& K, const Vec<k>& h, const Mat<k, k>& sigma) {
  const Vec<k> sigma_h = sigma * h;
  VelocityCone cone;
  cone.c = h.dot(sigma_h);
  for (int j = 0; j < 3; ++j) {
    const Vec<k> sigma_K_j = sigma * K.col(j);
    cone.q(j) = K.col(j).dot(sigma_h);
    for (int i = 0; i <= j; ++i) {
      cone.Q(i, j) = K.col(i).dot(sigma_K_j);
      cone.Q(j, i) = cone.Q(i, j);
    }
  }
  return cone;
}

Row LinearRow(const ChanceRow& row, const Controls& a, double hi) {
  Row out;
  out.a = a;
  out.hi = hi;
  out.price = row.price;
  out.key = row.key;
  return out;
}

}  // namespace

double VelocityCone::Sigma(const Vector3d& v_WT) const {
  const double variance = v_WT.dot(Q * v_WT) + 2 * q.dot(v_WT) + c;
  return std::sqrt(std::max(variance, 0.0));
}

Vector3d VelocityCone::Gradient(const Vector3d& v_WT) const {
  const double sigma = Sigma(v_WT);
  if (sigma < kNoDeviation) {
    return Vector3d::Zero();
  }
  return (Q * v_WT + q) / sigma;
}

Matrix3d VelocityCone::Curvature(const Vector3d& v_WT) const {
  const double sigma = Sigma(v_WT);
  if (sigma < kNoDeviation) {
    return Matrix3d::Zero();
  }
  const Vector3d g = (Q * v_WT + q) / sigma;
  return (Q - g * g.transpose()) / sigma;
}

double VelocityCone::UpperBound(const Vector3d& center, const Vector3d& radius) const {
  return Sigma(center) + std::sqrt(radius.dot(Q.cwiseAbs() * radius));
}

VelocityCone PlaneCone(const PlaneEstimate& plane, const Vector3d& p_WT, double eta_1ps) {
  Mat<4, 3> K = Mat<4, 3>::Zero();
  K.topRows<3>().setIdentity();
  Vec<4> h;
  h << eta_1ps * p_WT, -eta_1ps;
  return MakeCone<4>(K, h, plane.covariance);
}

VelocityCone SlabCone(const PlaneEstimate& plane, const Vector3d& p_WT, const Vector3d& gradient_W,
                      const Matrix3d& B, double eta_1ps) {
  const Vector3d& n = plane.n_W;
  const double along_n = n.dot(gradient_W);
  const double height_m = n.dot(p_WT - plane.p_WCentroid);
  const Vector3d B_n = B * n;
  Mat<4, 3> K;
  K.topRows<3>() = p_WT * B_n.transpose() - height_m * B - gradient_W * n.transpose();
  K.topRows<3>().diagonal().array() += along_n;
  K.row(3) = -B_n.transpose();
  Vec<4> h;
  h << eta_1ps * (along_n * p_WT - height_m * gradient_W), -eta_1ps * along_n;
  return MakeCone<4>(K, h, plane.covariance);
}

Matrix3d SlabCurvature(const PlaneEstimate& plane, const SlabDistance& distance) {
  Matrix3d R_WP;
  R_WP << plane.e1_W, plane.e2_W, plane.n_W;
  const Matrix3d B_P = BoxCurvature({.d_m = distance.d_m, .gradient_W = distance.away_P});
  return R_WP.lazyProduct(B_P).lazyProduct(R_WP.transpose());
}

VelocityCone PipeCone(const PipeEstimate& pipe, const AxisDistance& distance, double eta_1ps) {
  const Vector3d& e = distance.to_axis.gradient_W;
  const double rho = distance.to_axis.d_m;
  const double s = distance.s_m;
  const Mat<7, 7>& sigma = pipe.covariance;
  // Of δ = ∂p + s ∂l, the axis at s, with itself, with l and with r.
  const Matrix3d of_l = sigma.block<3, 3>(3, 3);
  const Matrix3d with_l = sigma.block<3, 3>(0, 3) + s * of_l;
  const Matrix3d of_s = sigma.block<3, 3>(0, 0) + s * (with_l + sigma.block<3, 3>(3, 0));
  const Vector3d with_r = sigma.block<3, 1>(0, 6) + s * sigma.block<3, 1>(3, 6);
  const Vector3d with_d = of_s * e + with_r;  // -∂d = e'δ + ∂r
  VelocityCone cone;
  cone.c = eta_1ps * eta_1ps * (e.dot(with_d) + e.dot(with_r) + sigma(6, 6));
  if (!(rho > 0)) {
    return cone;
  }
  if (distance.at_end) {
    const Matrix3d B = PipeCurvature(pipe, distance);
    cone.Q = B.lazyProduct(of_s).lazyProduct(B);
    cone.q = eta_1ps * (B * with_d);
    return cone;
  }
  const Vector3d& l = pipe.l_W;
  const Vector3d m = l.cross(e);
  const Vector3d l_e = with_l * e;
  const Matrix3d m_l = m * l.transpose();
  cone.Q = m.dot(of_s * m) / (rho * rho) * (m * m.transpose()) +
           m.dot(l_e) / rho * (m_l + m_l.transpose()) + e.dot(of_l * e) * (l * l.transpose());
  cone.q = eta_1ps * (m.dot(with_d) / rho * m + (e.dot(l_e) + e.dot(sigma.block<3, 1>(3, 6))) * l);
  return cone;
}

Matrix3d PipeCurvature(const PipeEstimate& pipe, const AxisDistance& distance) {
  const Vector3d& e = distance.to_axis.gradient_W;
  const double rho = distance.to_axis.d_m;
  if (!(rho > 0)) {
    return Matrix3d::Zero();
  }
  if (distance.at_end) {
    return (Matrix3d::Identity() - e * e.transpose()) / rho;
  }
  const Vector3d m = pipe.l_W.cross(e);
  return m * m.transpose() / rho;
}

Matrix3d BoxCurvature(const PointDistance& distance) {
  const Vector3d& e = distance.gradient_W;
  if (!(distance.d_m > 0)) {
    return Matrix3d::Zero();
  }
  Matrix3d B = -(e * e.transpose());
  for (int i = 0; i < 3; ++i) {
    B(i, i) += e(i) != 0 ? 1 : 0;
  }
  return B / distance.d_m;
}

VelocityCone VoxelCone(const Matrix3d& B, double sigma_m, double eta_1ps) {
  VelocityCone cone;
  cone.Q = sigma_m * sigma_m * B.lazyProduct(B);
  cone.c = sigma_m * sigma_m * eta_1ps * eta_1ps;
  return cone;
}

PointSpread SpreadOf(const ArmVector& joint_rad2, const Mat<3, kControls>& J) {
  PointSpread spread;
  for (int j = 0; j < kArmJoints; ++j) {
    spread.t += joint_rad2(j) * (J.col(2 + j) * J.col(2 + j).transpose());
  }
  return spread;
}

PointSpread WithBase(const PointSpread& of_joints, const Matrix3d& base,
                     const Mat<3, kControls>& J) {
  const Vector3d turn = J.col(1);
  const Vector3d place_phi{base(0, 2), base(1, 2), 0};
  PointSpread spread = of_joints;
  spread.t.topLeftCorner<2, 2>() += base.topLeftCorner<2, 2>();
  spread.t += place_phi * turn.transpose() + turn * place_phi.transpose() +
              base(2, 2) * (turn * turn.transpose());
  spread.t_phi += place_phi + base(2, 2) * turn;
  spread.phi += base(2, 2);
  return spread;
}

void AddStateVariance(const PointSpread& spread, const Vector3d& gradient_W, double eta_1ps,
                      VelocityCone& cone) {
  const Vector3d h = eta_1ps * gradient_W;
  const Vector3d w = gradient_W.cross(Vector3d::UnitZ());
  cone.Q += spread.phi * (w * w.transpose());
  cone.q += spread.t_phi.dot(h) * w;
  cone.c += h.dot(spread.t * h);
}

void AddStateVariance(const PointSpread& spread, const Vector3d& gradient_W, const Matrix3d& B,
                      double eta_1ps, VelocityCone& cone) {
  AddStateVariance(spread, gradient_W, eta_1ps, cone);
  const Matrix3d B_t = B.lazyProduct(spread.t);  // B is symmetric
  const Matrix3d turn = B * spread.t_phi * gradient_W.cross(Vector3d::UnitZ()).transpose();
  cone.Q += B_t.lazyProduct(B) + turn + turn.transpose();
  cone.q += eta_1ps * (B_t * gradient_W);
}

Result<double> JointChanceQuantile(double alpha, int rows) {
  const Result<double> alone = ChanceQuantile(alpha);
  if (!alone.ok() || rows <= 1) {
    return alone;
  }
  return -NormalQuantile((1 - alpha) / rows);
}

Result<double> ChanceQuantile(double alpha) {
  if (!(alpha >= 0.5 && alpha < 1)) {
    return Status::kOutOfRange;
  }
  return NormalQuantile(alpha);
}

double ChanceExcess(const ChanceRow& row, const Controls& u, double z) {
  return row.a.dot(u) + z * row.cone.Sigma(row.J * u) - row.limit;
}

Row TangentCut(const ChanceRow& row, const Controls& u0, double z) {
  const Vector3d v0 = row.J * u0;
  const Controls slope = z * (row.J.transpose() * row.cone.Gradient(v0));
  return LinearRow(row, row.a + slope, row.limit - z * row.cone.Sigma(v0) + slope.dot(u0));
}

Row FrozenRow(const ChanceRow& row, const Controls& u0, double z) {
  const double hi = row.limit - z * row.cone.Sigma(row.J * u0);
  return LinearRow(row, row.a, row.price > 0 ? hi : std::max(hi, 0.0));
}

Row WorstCaseRow(const ChanceRow& row, const Controls& lb, const Controls& ub, double z) {
  const Vector3d center = row.J * ((lb + ub) / 2);
  const Vector3d radius = row.J.cwiseAbs() * ((ub - lb) / 2);
  const double hi = row.limit - z * row.cone.UpperBound(center, radius);
  return LinearRow(row, row.a, row.price > 0 ? hi : std::max(hi, 0.0));
}

}  // namespace pipewright
