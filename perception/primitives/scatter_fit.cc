// SPDX-License-Identifier: MIT
#include "perception/primitives/scatter_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace pipewright {
namespace {

constexpr int kSteps = 15;
constexpr double kSettled = 1e-6;  // m, rad
constexpr double kLargeTilt = 0.7;
constexpr double kLongStep_m = 0.3;
constexpr double kOnALine = 1e-6;  // share of the largest eigenvalue

}  // namespace

Result<PlaneFit> FitScatteredPlane(std::span<const Eigen::Vector3f> p_SQ, double sigma_m,
                                   const InlierGate& gate) {
  const auto count = static_cast<double>(p_SQ.size());
  if (count < 4) {
    return Status::kInfeasible;
  }
  Vector3d c = Vector3d::Zero();
  for (const Eigen::Vector3f& p : p_SQ) {
    c += p.cast<double>() / count;
  }
  Matrix3d S = Matrix3d::Zero();
  for (const Eigen::Vector3f& p : p_SQ) {
    const Vector3d w = p.cast<double>() - c;
    S += w * w.transpose();
  }
  if (!S.allFinite()) {
    return Status::kInfeasible;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(S);
  const Vector3d& lambda = eigen.eigenvalues();
  PlaneFit fit;
  fit.n_S = eigen.eigenvectors().col(0);
  fit.d_m = fit.n_S.dot(c);
  if (lambda(1) <= kOnALine * lambda(2) || std::abs(fit.d_m) < 1e-6) {
    return Status::kInfeasible;
  }
  if (fit.d_m > 0) {
    fit.n_S = -fit.n_S;
    fit.d_m = -fit.d_m;
  }
  const double kept = KeptInformation(gate.sigmas);
  const double variance_m2 = std::max(lambda(0), 0.0) / ((count - 3) * kept);
  fit.count = static_cast<int>(count);
  fit.chi2 = variance_m2 / (sigma_m * sigma_m);
  Mat<4, 3> G = Mat<4, 3>::Zero();
  for (int k = 0; k < 2; ++k) {
    const Vector3d e = eigen.eigenvectors().col(k + 1);
    G.block<3, 1>(0, k) = e;
    G(3, k) = c.dot(e);
  }
  G(3, 2) = 1;
  const Vector3d variance = Vector3d(1 / lambda(1), 1 / lambda(2), 1 / count) * variance_m2 / kept;
  fit.covariance = G * variance.asDiagonal() * G.transpose();
  return fit;
}

Result<CylinderFit> FitScatteredCylinder(std::span<const Eigen::Vector3f> p_SQ,
                                         const CylinderFit& start, double sigma_m,
                                         const InlierGate& gate) {
  const auto count = static_cast<double>(p_SQ.size());
  if (count < 6) {
    return Status::kInfeasible;
  }
  Vector3d mean = Vector3d::Zero();
  for (const Eigen::Vector3f& p : p_SQ) {
    mean += p.cast<double>() / count;
  }
  CylinderFit fit = start;
  for (int step = 0; step < kSteps; ++step) {
    fit.p_S += fit.l_S.dot(mean - fit.p_S) * fit.l_S;
    const Vector3d e1 = fit.l_S.unitOrthogonal();
    const Vector3d e2 = fit.l_S.cross(e1);
    const double bias_m = sigma_m * sigma_m / (2 * fit.radius_m);
    Mat<5, 5> N = Mat<5, 5>::Zero();
    Vec<5> b = Vec<5>::Zero();
    double squares_m2 = 0;
    for (const Eigen::Vector3f& point : p_SQ) {
      const Vector3d w = point.cast<double>() - fit.p_S;
      const double x = e1.dot(w);
      const double y = e2.dot(w);
      const double rho = std::max(1e-6, std::sqrt(x * x + y * y));
      const double s = fit.l_S.dot(w);
      const Vec<5> J{x / rho, y / rho, s * x / rho, s * y / rho, 1};
      const double residual = rho - fit.radius_m - bias_m;
      N += J * J.transpose();
      b += J * residual;
      squares_m2 += residual * residual;
    }
    const Eigen::LDLT<Mat<5, 5>> ldlt(N);
    if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 1e-9 * count)) {
      return Status::kInfeasible;
    }
    const Vec<5> delta = ldlt.solve(b);
    if (!delta.allFinite() || delta.segment<2>(2).cwiseAbs().maxCoeff() > kLargeTilt ||
        delta.head<2>().cwiseAbs().maxCoeff() > kLongStep_m || fit.radius_m + delta(4) <= 0) {
      return Status::kInfeasible;
    }
    if (delta.cwiseAbs().maxCoeff() < kSettled) {
      const double kept = KeptInformation(gate.sigmas);
      const double variance_m2 = squares_m2 / ((count - 5) * kept);
      fit.count = static_cast<int>(count);
      fit.chi2 = variance_m2 / (sigma_m * sigma_m);
      Mat<7, 5> G = Mat<7, 5>::Zero();
      G.block<3, 1>(0, 0) = G.block<3, 1>(3, 2) = e1;
      G.block<3, 1>(0, 1) = G.block<3, 1>(3, 3) = e2;
      G(6, 4) = 1;
      const Mat<5, 5> inverse = ldlt.solve(Mat<5, 5>::Identity());
      fit.covariance = G * (inverse * (variance_m2 / kept)) * G.transpose();
      return fit;
    }
    fit.p_S += delta(0) * e1 + delta(1) * e2;
    fit.l_S = (fit.l_S + delta(2) * e1 + delta(3) * e2).normalized();
    fit.radius_m += delta(4);
  }
  return Status::kIterationLimit;
}

}  // namespace pipewright
