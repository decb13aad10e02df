// SPDX-License-Identifier: MIT
#include "tests/bench/svfi_share.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

namespace pipewright::bench {
namespace {

/// What is uncertain: a surface's parameters, (n, d), (p, l, r) or a post's place, and what is
/// wrong with q.
struct Parameters {
  Eigen::VectorXd theta;
  Configuration dq = Configuration::Zero();
};

/// The VFI of a robot point, f = ∇d'v + η (d − d_safe), without the controller's distances or
/// cones.
struct Vfi {
  const Instance* instance = nullptr;
  int point = 0;

  /// `known_J`: an error of q moves the point, but not its velocity.
  double operator()(const Parameters& p, bool known_J) const {
    const Configuration q = instance->state.q + p.dq;
    return At(p.theta, PointAt(q, point),
              JacobianAt(known_J ? instance->state.q : q, point) * instance->u);
  }
  double At(const Eigen::VectorXd& theta, const Vector3d& t, const Vector3d& v) const {
    const Surface& estimate = instance->estimate;
    const double eta = EtaOf(estimate.kind);
    const double safe_m = SafeOf(estimate.kind, point);
    if (estimate.kind == Primitive::kPlane) {  // linear in θ, |n| = 1 or not: [CFNBV] (13)
      const Vector3d n = theta.head<3>();
      return n.dot(v) + eta * (n.dot(t) - theta(3) - safe_m);
    }
    if (estimate.kind == Primitive::kVoxel) {
      const Eigen::Vector2d to = t.head<2>() - theta;
      const Eigen::Vector2d box = to.cwiseMax(-estimate.half_m).cwiseMin(estimate.half_m);
      const Eigen::Vector2d off = to - box;
      return off.dot(v.head<2>()) / off.norm() + eta * (off.norm() - safe_m);
    }
    const double half_m = estimate.half_m + kInflation_m;
    const Vector3d p = theta.head<3>();
    const Vector3d l = theta.segment<3>(3).normalized();
    const double s = std::clamp(l.dot(t - p), -half_m, half_m);
    const Vector3d off = t - p - s * l;
    return off.dot(v) / off.norm() + eta * (off.norm() - theta(6) - safe_m);
  }
};

Eigen::VectorXd ThetaOf(const Surface& s) {
  Eigen::VectorXd theta(s.kind == Primitive::kPlane ? 4 : s.kind == Primitive::kVoxel ? 2 : 7);
  if (s.kind == Primitive::kPlane) {
    theta << s.axis, s.axis.dot(s.p);
  } else if (s.kind == Primitive::kVoxel) {
    theta << s.p.head<2>();
  } else {
    theta << s.p, s.axis, s.radius_m;
  }
  return theta;
}

Eigen::MatrixXd CovarianceOf(const Surface& s) {
  if (s.kind == Primitive::kVoxel) {
    return s.sigma_m * s.sigma_m * Eigen::Matrix2d::Identity();
  }
  const Scene scene = s.ToScene();
  return s.kind == Primitive::kPlane ? Eigen::MatrixXd(scene.planes[0].covariance)
                                     : Eigen::MatrixXd(scene.pipes[0].covariance);
}

/// L with Σ = LL'; Σ is singular.
Eigen::MatrixXd Root(const Eigen::MatrixXd& sigma) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(sigma);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

/// f linear in the parameters: mean + spread'n, n normal. What q's joints do to the velocity is
/// left out, as the rows leave it out; "full" has it.
struct Linear {
  double mean = 0;
  Eigen::VectorXd spread;
};

Linear LinearOf(const Vfi& f) {
  constexpr double kStep = 1e-6;
  const Surface& estimate = f.instance->estimate;
  const Parameters at{ThetaOf(estimate)};
  const auto slope = [&](const auto& coordinate, bool known_J) {
    Parameters hi = at;
    Parameters lo = at;
    coordinate(hi) += kStep;
    coordinate(lo) -= kStep;
    return (f(hi, known_J) - f(lo, known_J)) / (2 * kStep);
  };
  Eigen::VectorXd by_theta(at.theta.size());
  for (int k = 0; k < by_theta.size(); ++k) {
    by_theta(k) = slope([k](Parameters& p) -> double& { return p.theta(k); }, false);
  }
  const Eigen::VectorXd theta_spread = Root(CovarianceOf(estimate)).transpose() * by_theta;
  Linear linear{f(at, false), theta_spread};
  if (f.instance->unsure) {
    linear.spread.conservativeResize(theta_spread.size() + kDof);
    for (int i = 0; i < kDof; ++i) {
      const double variance = i < 3 ? UnsureState().base(i, i) : UnsureState().joint_rad2(i - 3);
      linear.spread(theta_spread.size() + i) =
          std::sqrt(variance) * slope([i](Parameters& p) -> double& { return p.dq(i); }, i >= 3);
    }
  }
  return linear;
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
    std::vector<Vfi> vfis;
    std::vector<Linear> linears;
    for (const int point : instance.points) {
      vfis.push_back({&instance, point});
      linears.push_back(LinearOf(vfis.back()));
    }
    const int part = draws / count + (i < draws % count ? 1 : 0);
    Eigen::VectorXd normal(linears.front().spread.size());
    for (int k = 0; k < part; ++k) {
      for (double& x : normal) {
        x = rng.Normal();
      }
      Parameters truth{ThetaOf(instance.estimate.Draw(rng))};
      if (instance.unsure) {
        truth.dq = DrawState(Configuration::Zero(), rng);
      }
      bool linear = true;
      bool with_buffer = true;
      bool full = true;
      for (std::size_t v = 0; v < vfis.size(); ++v) {
        const double f = linears[v].mean + linears[v].spread.dot(normal);
        linear = linear && f >= 0;
        with_buffer = with_buffer && f >= instance.buffer_mps;
        full = full && vfis[v](truth, false) >= 0;
      }
      shares.first_order.held += linear ? 1 : 0;
      shares.with_buffer.held += with_buffer ? 1 : 0;
      shares.full.held += full ? 1 : 0;
    }
    shares.first_order.draws += part;
    shares.with_buffer.draws += part;
    shares.full.draws += part;
  }
  return shares;
}

Share DrawEstimates(std::span<const Instance> instances, int draws, Rng& rng) {
  Share share;
  const int count = static_cast<int>(instances.size());
  for (int i = 0; i < count; ++i) {
    const Instance& instance = instances[static_cast<std::size_t>(i)];
    const Surface& truth = instance.estimate;
    const Eigen::VectorXd theta = ThetaOf(truth);
    std::vector<Vfi> vfis;
    std::vector<Vector3d> t;
    std::vector<Mat<3, kControls>> J;
    for (const int point : instance.points) {
      vfis.push_back({&instance, point});
      t.push_back(PointAt(instance.state.q, point));
      J.push_back(JacobianAt(instance.state.q, point));
    }
    const int part = draws / count + (i < draws % count ? 1 : 0);
    for (int n = 0; n < part; ++n) {
      const auto controller = std::make_unique<WholeBodyController>(*instance.before);
      const Surface seen = truth.Draw(rng);
      RobotState state = instance.state;
      Goal goal = instance.goal;
      if (instance.unsure) {
        state.q = DrawState(state.q, rng);
      }
      if (truth.kind == Primitive::kVoxel) {  // posts stand on a grid: all else moves instead
        state.q.head<2>() -= (seen.p - truth.p).head<2>();
        goal.p_WS -= seen.p - truth.p;
      }
      const Scene scene = seen.ToScene();
      const Controls u = controller
                             ->Step({state, scene, truth.Field(), goal,
                                     instance.unsure ? &UnsureState() : nullptr},
                                    instance.now)
                             .u;
      bool held = true;
      for (std::size_t v = 0; v < vfis.size(); ++v) {
        held = held && vfis[v].At(theta, t[v], J[v] * u) >= 0;
      }
      share.held += held ? 1 : 0;
    }
    share.draws += part;
  }
  return share;
}

}  // namespace pipewright::bench
