// SPDX-License-Identifier: MIT
#include "perception/primitives/fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/primitives/four_floats.h"
#include "perception/primitives/normal_equations.h"

namespace pipewright {

double SurfaceSigma(const Vector3d& p_SQ, const Vector3d& g_S, const DepthNoise& noise) {
  const double z = p_SQ.z();
  const double length = std::sqrt(p_SQ.squaredNorm());
  const double along = std::max(std::abs(g_S.dot(p_SQ)), kGrazing * length) / z;  // |g'x|
  return along * z * z * noise.SigmaInverse(1 / z);
}

double KeptInformation(double c) {
  if (!(c < 8)) {
    return 1;
  }
  const double density = std::exp(-c * c / 2) / std::sqrt(2 * std::numbers::pi);
  return 1 - 2 * c * density / std::erf(c / std::numbers::sqrt2);
}

namespace {

struct PlaneSums {
  Matrix3d N = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  double chi2 = 0;
};

/// The same of four points at a time, in single precision; of so few that what is rounded off is
/// far below their noise.
struct FourPlaneSums {
  static constexpr int kMaxPoints = 256;
  Floats xx{}, xy{}, x1{}, yy{}, y1{}, one{};
  Floats bx{}, by{}, b1{};
  Floats chi2{};

  void Add(const Floats& x, const Floats& y, const Floats& residual, const Floats& weight) {
    const Floats wx = weight * x;
    const Floats wy = weight * y;
    const Floats wr = weight * residual;
    xx += wx * x, xy += wx * y, x1 += wx, yy += wy * y, y1 += wy, one += weight;
    bx += wr * x, by += wr * y, b1 += wr;
    chi2 += wr * residual;
  }

  void AddTo(PlaneSums& sums) const {
    Matrix3d N;
    N << Sum(xx), Sum(xy), Sum(x1), Sum(xy), Sum(yy), Sum(y1), Sum(x1), Sum(y1), Sum(one);
    sums.N += N;
    sums.b += Vector3d(Sum(bx), Sum(by), Sum(b1));
    sums.chi2 += Sum(chi2);
  }
};

/// The sums about plane m, or, without one, those of the readings' own inverse depths.
PlaneSums SumUp(std::span<const Eigen::Vector3f> points, const Vector3d* m,
                const DepthNoise& noise) {
  const Eigen::Vector3f plane =
      m != nullptr ? Eigen::Vector3f(m->cast<float>()) : Eigen::Vector3f::Zero();
  const int count = static_cast<int>(points.size());
  PlaneSums sums;
  for (int begin = 0; begin < count; begin += FourPlaneSums::kMaxPoints) {
    FourPlaneSums of_part;
    const int end = std::min(count, begin + FourPlaneSums::kMaxPoints);
    for (int k = begin; k < end; k += kLanes) {
      const FourReadings p(points.data(), k, end);
      const Floats own = 1 / p.z;
      const Floats x = p.x * own;
      const Floats y = p.y * own;
      const Floats w = m != nullptr ? plane.x() * x + plane.y() * y + plane.z() : own;
      const Floats residual = m != nullptr ? w * (1 - w * p.z) : own;
      of_part.Add(x, y, residual, p.there ? 1 / VarianceInverse(w, noise) : Floats{});
    }
    of_part.AddTo(sums);
  }
  return sums;
}

}  // namespace

Result<PlaneFit> FitPlane(std::span<const Eigen::Vector3f> p_SQ, const DepthNoise& noise,
                          const InlierGate& gate) {
  const PlaneSums sums = SumUp(p_SQ, nullptr, noise);
  Matrix3d covariance_m;
  if (p_SQ.size() < 4 || !Invert<3>(sums.N, covariance_m)) {
    return Status::kInfeasible;
  }
  return FitPlane(p_SQ, covariance_m * sums.b, noise, gate);
}

Result<PlaneFit> FitPlane(std::span<const Eigen::Vector3f> p_SQ, Vector3d m,
                          const DepthNoise& noise, const InlierGate& gate) {
  const int count = static_cast<int>(p_SQ.size());
  const PlaneSums sums = SumUp(p_SQ, &m, noise);
  Matrix3d covariance_m;
  if (count < 4 || !Invert<3>(sums.N, covariance_m)) {
    return Status::kInfeasible;
  }
  const Vector3d step = covariance_m * sums.b;
  m += step;
  const double length = std::sqrt(m.squaredNorm());
  if (!(length > 1e-3) || !std::isfinite(length)) {
    return Status::kInfeasible;
  }
  const double kept = KeptInformation(gate.sigmas);
  PlaneFit fit;
  fit.count = count;
  fit.chi2 = std::max(0.0, sums.chi2 - step.dot(sums.b)) / ((count - 3) * kept);
  fit.n_S = -m / length;
  fit.d_m = -1 / length;
  // n = −m/|m|, d = −1/|m|:  ∂n = −(I − nn') ∂m/|m|,  ∂d = m'∂m/|m|³
  Mat<4, 3> G;
  G.topRows<3>() = -(Matrix3d::Identity() - fit.n_S * fit.n_S.transpose()) / length;
  G.row(3) = -fit.n_S.transpose() / (length * length);
  fit.covariance = G * (covariance_m * (Widening(fit.chi2, count - 3) / kept)) * G.transpose();
  return fit;
}

}  // namespace pipewright
