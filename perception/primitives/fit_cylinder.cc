// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/primitives/fit.h"
#include "perception/primitives/four_floats.h"
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

/// The same of four points at a time, in single precision; of so few that what is rounded off is
/// far below their noise.
struct FourCylinderSums {
  static constexpr int kMaxPoints = 256;
  Floats N[5][5] = {};  ///< the lower half
  Floats b[5] = {};
  Floats chi2{};

  void Add(const Floats (&J)[5], const Floats& residual, const Floats& weight) {
    const Floats wr = weight * residual;
    chi2 += wr * residual;
    for (int i = 0; i < 5; ++i) {
      b[i] += wr * J[i];
      const Floats wJ = weight * J[i];
      for (int j = 0; j <= i; ++j) {
        N[i][j] += wJ * J[j];
      }
    }
  }
  void AddTo(CylinderSums& sums) const {
    sums.chi2 += pipewright::Sum(chi2);
    for (int i = 0; i < 5; ++i) {
      sums.b(i) += pipewright::Sum(b[i]);
      for (int j = 0; j <= i; ++j) {
        sums.N(i, j) += pipewright::Sum(N[i][j]);
      }
    }
  }
};

/// A vector for scalar products with four others.
struct Along {
  explicit Along(const Vector3d& v) : v_(v.cast<float>()) {}
  Floats operator()(const Floats& x, const Floats& y, const Floats& z) const {
    return v_.x() * x + v_.y() * y + v_.z() * z;
  }
  Eigen::Vector3f v_;
};

/// Sums over all points of what `add(four, sums)` adds.
template <typename AddFour>
CylinderSums SumUp(std::span<const Eigen::Vector3f> points, const AddFour& add) {
  CylinderSums sums;
  const int count = static_cast<int>(points.size());
  for (int begin = 0; begin < count; begin += FourCylinderSums::kMaxPoints) {
    FourCylinderSums of_part;
    const int end = std::min(count, begin + FourCylinderSums::kMaxPoints);
    for (int k = begin; k < end; k += kLanes) {
      add(FourReadings(points.data(), k, end), of_part);
    }
    of_part.AddTo(sums);
  }
  sums.N.triangularView<Eigen::StrictlyUpper>() = sums.N.transpose();
  return sums;
}

/// Residuals r − ρ: distances to the surface.
CylinderSums Sum(std::span<const Eigen::Vector3f> points, const CylinderFit& at, const Vector3d& e1,
                 const Vector3d& e2, const DepthNoise& noise) {
  const Along along(at.l_S), along_1(e1), along_2(e2);
  const Eigen::Vector3f o = at.p_S.cast<float>();
  const auto radius_m = static_cast<float>(at.radius_m);
  return SumUp(points, [&](const FourReadings& p, FourCylinderSums& sums) {
    const Floats x = p.x - o.x();
    const Floats y = p.y - o.y();
    const Floats z = p.z - o.z();
    const Floats s = along(x, y, z);
    const Floats x1 = along_1(x, y, z);
    const Floats x2 = along_2(x, y, z);
    const Floats rho = SquareRoot(x1 * x1 + x2 * x2);
    const Masks counts = p.there & (rho >= 1e-6F);
    const Floats g1 = counts ? x1 / rho : Floats{};
    const Floats g2 = counts ? x2 / rho : Floats{};
    const Floats facing_m = g1 * along_1(p.x, p.y, p.z) + g2 * along_2(p.x, p.y, p.z);
    const Floats grazing_m =
        static_cast<float>(kGrazing) * SquareRoot(p.x * p.x + p.y * p.y + p.z * p.z);
    const Floats sigma =
        Greater(Absolute(facing_m), grazing_m) * p.z * SigmaInverse(1 / p.z, noise);
    const Floats J[5] = {g1, g2, s * g1, s * g2, Fill(1)};
    sums.Add(J, rho - radius_m, counts ? 1 / (sigma * sigma) : Floats{});
  });
}

/// The same with residuals (ẑ − z)/ẑ², where ẑ is the depth at which the ray of a reading meets the
/// cylinder: their noise is even and does not bend with the surface, so no bias is left. Rays that
/// would graze the cylinder, or miss it, are left out; `hits` are the others. See PipeRays for ẑ.
///   F(q, θ) = ρ(q) − r = 0 on q = ẑ x:   ∂(1/ẑ)/∂θ = F_θ / (g'x ẑ²)
CylinderSums SumAlongRays(std::span<const Eigen::Vector3f> points, const CylinderFit& at,
                          const Vector3d& e1, const Vector3d& e2, const DepthNoise& noise,
                          int& hits) {
  const Along along(at.l_S), along_1(e1), along_2(e2);
  const Along along_moment(at.p_S.cross(at.l_S));
  const auto lp = static_cast<float>(at.l_S.dot(at.p_S));
  const auto p1 = static_cast<float>(e1.dot(at.p_S));
  const auto p2 = static_cast<float>(e2.dot(at.p_S));
  const auto radius_m = static_cast<float>(at.radius_m);
  const Floats one = Fill(1);
  Masks met{};
  CylinderSums sums = SumUp(points, [&](const FourReadings& p, FourCylinderSums& of_part) {
    const Floats x = p.x / p.z;
    const Floats y = p.y / p.z;
    const Floats x1 = along_1(x, y, one);
    const Floats x2 = along_2(x, y, one);
    const Floats A = x1 * x1 + x2 * x2;
    const Floats moment = along_moment(x, y, one);
    const Floats root = SquareRoot(radius_m * radius_m * A - moment * moment);
    const Floats z = (x1 * p1 + x2 * p2 - root) / A;
    const Floats facing = -root / radius_m;  // g'x
    const auto grazing2 = static_cast<float>(kGrazing * kGrazing);
    const Masks hit = p.there & (z > 0) & (facing * facing >= grazing2 * (x * x + y * y + 1));
    met -= hit;
    const Floats s = z * along(x, y, one) - lp;
    const Floats g1 = (z * x1 - p1) / radius_m;
    const Floats g2 = (z * x2 - p2) / radius_m;
    const Floats w = 1 / z;
    const Floats scale = w * w / facing;
    Floats J[5] = {-g1 * scale, -g2 * scale, -s * g1 * scale, -s * g2 * scale, -scale};
    for (Floats& partial : J) {
      partial = hit ? partial : Floats{};
    }
    const Floats residual = hit ? (z - p.z) * w * w : Floats{};
    of_part.Add(J, residual, hit ? 1 / VarianceInverse(w, noise) : Floats{});
  });
  hits = pipewright::Sum(met);
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
