// SPDX-License-Identifier: MIT
#include "tests/bench/svfi_share.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tests/ctrl/constraints/random_world.h"

namespace pipewright::bench {
namespace {

/// A surface's parameters: (n, d) or (p, l, r).
using Parameters = Eigen::VectorXd;

/// The VFI of a robot point, f = ∇d'v + η (d − d_safe), without any of the controller's code.
struct Vfi {
  Primitive kind = Primitive::kPlane;
  Vector3d t;
  Vector3d v;
  double safe_m = 0;
  double half_m = 0;  ///< of a pipe's axis, inflation included

  /// Planes: linear in θ as it stands, |n| = 1 or not. [CFNBV] (13)
  double operator()(const Parameters& theta) const {
    if (kind == Primitive::kPlane) {
      const Vector3d n = theta.head<3>();
      return n.dot(v) + kEta_1ps * (n.dot(t) - theta(3) - safe_m);
    }
    const Vector3d p = theta.head<3>();
    const Vector3d l = theta.segment<3>(3).normalized();
    const double s = std::clamp(l.dot(t - p), -half_m, half_m);
    const Vector3d off = t - p - s * l;
    return off.dot(v) / off.norm() + kEta_1ps * (off.norm() - theta(6) - safe_m);
  }
};

Parameters ParametersOf(const Surface& s) {
  Parameters theta(s.kind == Primitive::kPlane ? 4 : 7);
  if (s.kind == Primitive::kPlane) {
    theta << s.axis, s.axis.dot(s.p);
  } else {
    theta << s.p, s.axis, s.radius_m;
  }
  return theta;
}

Eigen::MatrixXd CovarianceOf(const Surface& s) {
  const Scene scene = s.ToScene();
  return s.kind == Primitive::kPlane ? Eigen::MatrixXd(scene.planes[0].covariance)
                                     : Eigen::MatrixXd(scene.pipes[0].covariance);
}

/// L with Σ = LL'; Σ is singular.
Eigen::MatrixXd Root(const Eigen::MatrixXd& sigma) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(sigma);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

Parameters Slope(const Vfi& f, const Parameters& theta) {
  constexpr double kStep = 1e-6;
  Parameters slope(theta.size());
  for (int k = 0; k < theta.size(); ++k) {
    Parameters hi = theta;
    Parameters lo = theta;
    hi(k) += kStep;
    lo(k) -= kStep;
    slope(k) = (f(hi) - f(lo)) / (2 * kStep);
  }
  return slope;
}

Vfi VfiOf(const Instance& instance) {
  return {instance.estimate.kind, instance.t, instance.v, instance.safe_m,
          instance.estimate.half_m + kInflation_m};
}

}  // namespace

double Share::Bound(int side) const {
  constexpr double kZ = 2.3263478740408408;  // 99 %
  if (draws == 0) {
    return side < 0 ? 0 : 1;
  }
  const double n = static_cast<double>(draws);
  const double p = value();
  const double half = kZ * std::sqrt(p * (1 - p) / n + kZ * kZ / (4 * n * n));
  return (p + kZ * kZ / (2 * n) + side * half) / (1 + kZ * kZ / n);
}

TruthShares DrawTruths(std::span<const Instance> instances, int draws, Rng& rng) {
  TruthShares shares;
  const int count = static_cast<int>(instances.size());
  for (int i = 0; i < count; ++i) {
    const Instance& instance = instances[static_cast<std::size_t>(i)];
    const Vfi f = VfiOf(instance);
    const Parameters theta = ParametersOf(instance.estimate);
    const Parameters spread = Root(CovarianceOf(instance.estimate)).transpose() * Slope(f, theta);
    const double mean = f(theta);
    const int part = draws / count + (i < draws % count ? 1 : 0);
    for (int k = 0; k < part; ++k) {
      double linear = mean;
      for (int c = 0; c < spread.size(); ++c) {
        linear += spread(c) * rng.Normal();
      }
      shares.first_order.held += linear >= 0 ? 1 : 0;
      shares.with_buffer.held += linear >= instance.buffer_mps ? 1 : 0;
      shares.full.held += f(ParametersOf(instance.estimate.Draw(rng))) >= 0 ? 1 : 0;
    }
    shares.first_order.draws += part;
    shares.with_buffer.draws += part;
    shares.full.draws += part;
  }
  return shares;
}

Share DrawEstimates(std::span<const Instance> instances, int draws, Rng& rng) {
  static const test::VoxelWorld world;
  Share share;
  const int count = static_cast<int>(instances.size());
  for (int i = 0; i < count; ++i) {
    const Instance& instance = instances[static_cast<std::size_t>(i)];
    const Surface& truth = instance.estimate;
    const Parameters theta = ParametersOf(truth);
    Vfi f = VfiOf(instance);
    const Kinematics<kArmJoints> k(TracerUf7(), instance.state.q);
    const bool is_base = instance.point >= TracerUf7Shapes().spheres.size();
    const int body = is_base ? 0 : TracerUf7Shapes().spheres[instance.point].body;
    const Mat<3, kControls> J = k.PointJacobianAt(body, instance.t);
    const int part = draws / count + (i < draws % count ? 1 : 0);
    for (int n = 0; n < part; ++n) {
      const auto controller = std::make_unique<WholeBodyController>(*instance.before);
      const Scene seen = truth.Draw(rng).ToScene();
      f.v = J *
            controller->Step({instance.state, seen, world.field(), instance.goal}, instance.now).u;
      share.held += f(theta) >= 0 ? 1 : 0;
    }
    share.draws += part;
  }
  return share;
}

}  // namespace pipewright::bench
