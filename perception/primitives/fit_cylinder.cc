// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/primitives/fit.h"
#include "perception/primitives/normal_equations.h"

namespace pipewright {
namespace {

constexpr int kSteps = 12;
constexpr double kSettled = 1e-5;   // m, rad: the step after it would be far smaller
constexpr double kNoStep = 1e-4;    // squared, in standard deviations
constexpr double kNear = 3e-4;      // where the exact residuals take over
constexpr double kLargeTilt = 0.7;  // a step beyond this is no refinement
constexpr double kLongStep_m = 0.3;
constexpr double kMinHits = 0.6;  // share of the readings whose rays must meet the cylinder

/// The sums of one Gauss-Newton step.
struct CylinderSums {
  Mat<5, 5> N = Mat<5, 5>::Zero();
  Vec<5> b = Vec<5>::Zero();
  double chi2 = 0;
};

CylinderSums Sum(std::span<const Eigen::Vector3f> points, const CylinderFit& at, const Vector3d& e1,
                 const Vector3d& e2, const DepthNoise& noise) {
  CylinderSums sums;
  for (const Eigen::Vector3f& point : points) {
    const Vector3d p = point.cast<double>();
    const Vector3d w = p - at.p_S;
    const double s = at.l_S.dot(w);
    const double x = e1.dot(w);
    const double y = e2.dot(w);
    const double rho = std::sqrt(x * x + y * y);
    if (rho < 1e-6) {
      continue;
    }
    const double gx = x / rho;
    const double gy = y / rho;
    const double sigma = SurfaceSigma(p, gx * e1 + gy * e2, noise);
    const double weight = 1 / (sigma * sigma);
    const double residual = rho - at.radius_m;
    const Vec<5> J{-gx, -gy, -s * gx, -s * gy, -1};
    const Vec<5> wJ = weight * J;
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j <= i; ++j) {
        sums.N(i, j) += wJ(i) * J(j);
      }
    }
    sums.b -= wJ * residual;
    sums.chi2 += weight * residual * residual;
  }
  sums.N.triangularView<Eigen::StrictlyUpper>() = sums.N.transpose();
  return sums;
}

/// The same with residuals (ẑ − z)/ẑ², where ẑ is the depth at which the ray of a reading meets the
/// cylinder: their noise is even and does not bend with the surface, so no bias is left. Rays that
/// would graze the cylinder, or miss it, are left out; `hits` are the others.
///   F(q, θ) = ρ(q) − r = 0 on q = ẑ x:   ∂(1/ẑ)/∂θ = F_θ / (g'x ẑ²)
CylinderSums SumAlongRays(std::span<const Eigen::Vector3f> points, const CylinderFit& at,
                          const Vector3d& e1, const Vector3d& e2, const DepthNoise& noise,
                          int& hits) {
  CylinderSums sums;
  hits = 0;
  const double pp = at.p_S.squaredNorm();
  const double lp = at.l_S.dot(at.p_S);
  for (const Eigen::Vector3f& point : points) {
    const double inverse_z = 1 / static_cast<double>(point.z());
    const Vector3d ray = point.cast<double>() * inverse_z;
    const double lx = at.l_S.dot(ray);
    const double A = ray.squaredNorm() - lx * lx;
    const double B = ray.dot(at.p_S) - lx * lp;
    const double root = B * B - A * (pp - lp * lp - at.radius_m * at.radius_m);
    if (!(root > 0)) {
      continue;
    }
    const double z = (B - std::sqrt(root)) / A;
    const Vector3d w = z * ray - at.p_S;
    const double s = at.l_S.dot(w);
    const double gx = e1.dot(w) / at.radius_m;
    const double gy = e2.dot(w) / at.radius_m;
    const double facing = gx * e1.dot(ray) + gy * e2.dot(ray);  // g'x
    if (facing * facing < kGrazing * kGrazing * ray.squaredNorm() || !(z > 0)) {
      continue;
    }
    ++hits;
    const double scale = 1 / (facing * z * z);
    const Vec<5> J{-gx * scale, -gy * scale, -s * gx * scale, -s * gy * scale, -scale};
    const double weight = 1 / noise.VarianceInverse(1 / z);
    const double residual = (z - static_cast<double>(point.z())) / (z * z);
    sums.b += weight * residual * J;
    sums.chi2 += weight * residual * residual;
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j <= i; ++j) {
        sums.N(i, j) += weight * J(i) * J(j);
      }
    }
  }
  sums.N.triangularView<Eigen::StrictlyUpper>() = sums.N.transpose();
  return sums;
}

Vector3d Mean(std::span<const Eigen::Vector3f> points) {
  Vector3d sum = Vector3d::Zero();
  for (const Eigen::Vector3f& p : points) {
    sum += p.cast<double>();
  }
  return sum / static_cast<double>(points.size());
}

/// Gauss-Newton steps over `sums_at(fit, e1, e2, readings used)` until they settle.
template <typename SumsAt>
Status Descend(CylinderFit& fit, const Vector3d& mean, double settled, double kept,
               const SumsAt& sums_at) {
  for (int step = 0; step < kSteps; ++step) {
    fit.p_S += fit.l_S.dot(mean - fit.p_S) * fit.l_S;
    const Vector3d e1 = fit.l_S.unitOrthogonal();
    const Vector3d e2 = fit.l_S.cross(e1);
    int used = 0;
    const CylinderSums sums = sums_at(fit, e1, e2, used);
    Mat<5, 5> inverse;
    if (used < 6 || !Invert<5>(sums.N, inverse)) {
      return Status::kInfeasible;
    }
    const Vec<5> delta = inverse * sums.b;
    if (!delta.allFinite() || delta.segment<2>(2).cwiseAbs().maxCoeff() > kLargeTilt ||
        delta.head<2>().cwiseAbs().maxCoeff() > kLongStep_m || fit.radius_m + delta(4) <= 0) {
      return Status::kInfeasible;
    }
    // Or a step that is nothing beside the error: rays come and go at the rim.
    if (delta.cwiseAbs().maxCoeff() < settled || delta.dot(sums.N * delta) < kNoStep) {
      fit.count = used;
      fit.chi2 = sums.chi2 / ((used - 5) * kept);
      Mat<7, 5> G = Mat<7, 5>::Zero();
      G.block<3, 1>(0, 0) = G.block<3, 1>(3, 2) = e1;
      G.block<3, 1>(0, 1) = G.block<3, 1>(3, 3) = e2;
      G(6, 4) = 1;
      fit.covariance = G * (inverse * (Widening(fit.chi2, used - 5) / kept)) * G.transpose();
      return Status::kOk;
    }
    fit.p_S += delta(0) * e1 + delta(1) * e2;
    fit.l_S = (fit.l_S + delta(2) * e1 + delta(3) * e2).normalized();
    fit.radius_m += delta(4);
  }
  return Status::kIterationLimit;
}

double KeptBy(const InlierGate& gate, const Vector3d& p_SQ, const DepthNoise& noise) {
  const double sigma_m = p_SQ.z() * p_SQ.z() * noise.SigmaInverse(1 / p_SQ.z());
  return KeptInformation(gate.sigmas + gate.slack_m / sigma_m);
}

}  // namespace

Result<CylinderFit> FitCylinderAlongRays(std::span<const Eigen::Vector3f> p_SQ,
                                         const CylinderFit& start, const DepthNoise& noise,
                                         const InlierGate& gate) {
  const auto count = static_cast<double>(p_SQ.size());
  if (count < 6) {
    return Status::kInfeasible;
  }
  const Vector3d mean = Mean(p_SQ);
  CylinderFit fit = start;
  const Status s = Descend(fit, mean, kSettled, KeptBy(gate, mean, noise),
                           [&](const CylinderFit& at, const Vector3d& e1, const Vector3d& e2,
                               int& used) { return SumAlongRays(p_SQ, at, e1, e2, noise, used); });
  if (s != Status::kOk) {
    return s;
  }
  return fit.count > kMinHits * count ? Result<CylinderFit>(fit) : Status::kInfeasible;
}

Result<CylinderFit> FitCylinder(std::span<const Eigen::Vector3f> p_SQ, const CylinderFit& start,
                                const DepthNoise& noise, const InlierGate& gate) {
  const int count = static_cast<int>(p_SQ.size());
  if (count < 6) {
    return Status::kInfeasible;
  }
  const Vector3d mean = Mean(p_SQ);
  const double kept = KeptBy(gate, mean, noise);
  const auto off_surface = [&](const CylinderFit& at, const Vector3d& e1, const Vector3d& e2,
                               int& used) {
    used = count;
    return Sum(p_SQ, at, e1, e2, noise);
  };
  CylinderFit fit = start;
  if (const Status s = Descend(fit, mean, kNear, kept, off_surface); s != Status::kOk) {
    return s;
  }
  if (auto exact = FitCylinderAlongRays(p_SQ, fit, noise, gate); exact.ok()) {
    return exact;
  }
  const Status s = Descend(fit, mean, kSettled, kept, off_surface);
  return s == Status::kOk ? Result<CylinderFit>(fit) : s;
}

}  // namespace pipewright
