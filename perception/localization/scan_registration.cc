// SPDX-License-Identifier: MIT
#include "perception/localization/scan_registration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace pipewright {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTiny = std::numeric_limits<double>::min();
constexpr double kUpright = 0.5;     ///< a normal with less across the vertical tells nothing
constexpr double kSettled_m = 5e-4;  ///< the kernel's reach at which steps may end

struct NormalEquations {
  Mat<3, 3> H = Mat<3, 3>::Zero();
  Mat<3, 3> H_false = Mat<3, 3>::Zero();
  Vector3d g = Vector3d::Zero();
  double best_placed_m2 = kInfinity;  ///< at 1 m, of the surfels that tell
  // Information of place and of heading, and that times the placement's variances.
  double w_place = kTiny;
  double w_heading = kTiny;
  double w_placed_m2 = 0;
  double w_placed_rad2 = 0;
  int associated = 0;
  int inliers = 0;
  double chi2 = 0;  ///< of the inliers
};

NormalEquations Linearise(const SurfelMap& map, const PipeLandmarks& pipes,
                          std::span<const ScanPoint> scan, const Isometry3d& X_BS,
                          const Vector3d& pose, double reach_m, double best_placed_m2,
                          const RegistrationConfig& config) {
  NormalEquations sum;
  const Isometry3d X_WS = BaseAt(pose) * X_BS;
  const Vector3d p_WS = X_WS.translation();
  for (const ScanPoint& point : scan) {
    const Vector3d p_WQ = X_WS * point.p_SQ.cast<double>();
    Surfel of_pipe;
    const Surfel* surfel = pipes.Find(p_WQ, of_pipe) >= 0 ? &of_pipe : map.Find(p_WQ);
    if (surfel == nullptr) {
      continue;
    }
    const Vector3d& n = surfel->n_W;
    if (!point.n_S.isZero() &&
        !(n.dot(X_WS.linear() * point.n_S.cast<double>()) > config.alike_cosine)) {
      continue;
    }
    const auto [r, var, cosine] = MisfitOf(*surfel, point.sigma_m, p_WQ, p_WS, config.model_m);
    if (!(cosine > config.view_cosine) || std::abs(r) > map.reach_m() + reach_m) {
      continue;  // grazing, or the surface's other side; or too far beside it
    }
    ++sum.associated;
    const double placed_m2 = surfel->placed.at_1m();
    const double worse_m2 = std::max(0.0, placed_m2 - best_placed_m2);
    if (r * r < kInlierSigmas * kInlierSigmas * (var + worse_m2)) {
      ++sum.inliers;
      sum.chi2 += r * r / (var + worse_m2);
    }
    const double wide_var = var + reach_m * reach_m;
    const double robust = 1 / (1 + r * r / (kInlierSigmas * kInlierSigmas * wide_var));
    const double w = robust * robust / (wide_var + worse_m2);
    Mat<3, 3> B = Mat<3, 3>::Identity();
    B.row(2) << pose.y() - p_WQ.y(), p_WQ.x() - pose.x(), 0;
    const Vector3d J = B * n;
    const Mat<3, 3> across = B.lazyProduct(B.transpose()) - J * J.transpose();
    sum.H += w * J * J.transpose();
    sum.H_false += w * (surfel->tilt_var_rad2 + config.model_rad * config.model_rad) * across;
    sum.g += w * r * J;
    if (n.head<2>().squaredNorm() > kUpright * kUpright) {
      sum.best_placed_m2 = std::min(sum.best_placed_m2, placed_m2);
    }
    const double of_place = w * J.head<2>().squaredNorm();
    const double of_heading = w * J.z() * J.z();
    sum.w_place += of_place;
    sum.w_heading += of_heading;
    sum.w_placed_m2 += of_place * surfel->placed.m2;
    sum.w_placed_rad2 += of_heading * surfel->placed.rad2;
  }
  return sum;
}

/// What the equations tell, direction by direction. In (x, y, phi) with phi at 1 m, as it is.
struct Solution {
  Vector3d step = Vector3d::Zero();
  Mat<3, 3> information = Mat<3, 3>::Zero();
  Mat<3, 3> determined = Mat<3, 3>::Zero();  ///< projects on the directions that are
  int directions = 0;
};

Solution Solve(const NormalEquations& sum, double clear, double information_min) {
  Solution solution;
  Eigen::SelfAdjointEigenSolver<Mat<3, 3>> solver;
  solver.computeDirect(sum.H);
  for (int k = 0; k < 3; ++k) {
    const Vector3d v = solver.eigenvectors().col(k);
    const double told = v.dot(sum.H * v);
    const double feigned = v.dot(sum.H_false * v);
    if (!(told > 0) || told < clear * feigned || told - feigned < information_min) {
      continue;
    }
    ++solution.directions;
    solution.determined += v * v.transpose();
    solution.step -= v * (v.dot(sum.g) / told);
    solution.information += (told - feigned) * v * v.transpose();
  }
  return solution;
}

bool Finite(const Isometry3d& X_BS, const Vector3d& guess) {
  return X_BS.matrix().allFinite() && guess.allFinite();
}

}  // namespace

Misfit MisfitOf(const Surfel& surfel, float sigma_m, const Vector3d& p_WQ, const Vector3d& p_WS,
                double model_m) {
  const Vector3d& n = surfel.n_W;
  const double cosine = -n.dot((p_WQ - p_WS).normalized());
  const Vector3d away = p_WQ - surfel.p_W;
  const double range_var = sigma_m * sigma_m * cosine * cosine;
  const double var = range_var + surfel.offset_var_m2 + surfel.rough_var_m2 +
                     surfel.tilt_var_rad2 * away.squaredNorm() + model_m * model_m;
  return {n.dot(away), var, cosine};
}

Isometry3d BaseAt(const Vector3d& pose) {
  Isometry3d X_WB = Isometry3d::Identity();
  X_WB.linear() = Eigen::AngleAxisd(pose.z(), Vector3d::UnitZ()).toRotationMatrix();
  X_WB.translation() << pose.x(), pose.y(), 0;
  return X_WB;
}

Status Register(const SurfelMap& map, const PipeLandmarks& pipes, std::span<const ScanPoint> scan,
                const Isometry3d& X_BS, const Vector3d& guess, const Vector3d& start,
                const RegistrationConfig& config, PoseFix& fix, RegistrationFigures& figures) {
  assert(Valid(config));
  figures = {};
  if (!Finite(X_BS, guess) || !start.allFinite()) {
    return Status::kOutOfRange;
  }
  const double known = config.known_min * static_cast<double>(scan.size());
  const auto enough = [&](int associated) {
    return associated >= config.points_min && associated >= known;
  };
  Vector3d pose = start;
  double reach_m = config.reach_m;
  NormalEquations sum;
  bool settled = false;
  while (!settled && figures.iterations < config.iterations) {
    ++figures.iterations;
    sum = Linearise(map, pipes, scan, X_BS, pose, reach_m, sum.best_placed_m2, config);
    if (!enough(sum.associated)) {
      figures.associated = sum.associated;
      return Status::kUnavailable;
    }
    const Vector3d step = Solve(sum, config.clear, 0).step;
    if (!step.allFinite()) {
      return Status::kOutOfRange;
    }
    pose += step;
    settled = reach_m <= kSettled_m && step.head<2>().norm() < config.step_m &&
              std::abs(step.z()) < config.step_rad;
    reach_m = reach_m > kSettled_m ? reach_m / 2 : 0;
  }
  sum = Linearise(map, pipes, scan, X_BS, pose, 0, sum.best_placed_m2, config);
  figures.pose = pose;
  figures.associated = sum.associated;
  figures.inliers = sum.inliers;
  figures.inlier_share = sum.associated > 0 ? 1.0 * sum.inliers / sum.associated : 0;
  figures.chi2 = sum.inliers > 0 ? sum.chi2 / sum.inliers : 0;
  if (!settled) {
    return Status::kIterationLimit;
  }
  if (!enough(sum.associated)) {
    return Status::kUnavailable;
  }
  if (figures.inlier_share < config.inliers_min) {
    return Status::kFault;
  }
  const Solution solution = Solve(sum, config.clear, 1 / (config.sigma_max * config.sigma_max));
  figures.directions = solution.directions;
  if (solution.directions == 0) {
    return Status::kInfeasible;
  }
  fix.pose = guess + solution.determined * (pose - guess);
  fix.information = solution.information / std::max(1.0, figures.chi2);
  fix.placed = {sum.w_placed_m2 / sum.w_place, sum.w_placed_rad2 / sum.w_heading};
  return Status::kOk;
}

}  // namespace pipewright
