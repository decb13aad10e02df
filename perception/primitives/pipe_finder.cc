// SPDX-License-Identifier: MIT
#include "perception/primitives/pipe_finder.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr int kAttempts = 8;       // hypotheses refined a frame
constexpr double kPatch_m = 0.12;  // radius about a draw's reading
constexpr int kMinPatch = 12;
constexpr double kReach_m = 1.5;        // along the axis from a hypothesis' middle
constexpr double kMinCurvature = 0.01;  // second eigenvalue of the normals: less is flat
constexpr float kNormalAgrees = 0.6F;   // cosine
constexpr double kSlack_m = 0.001;      // pipes are round to this

}  // namespace

std::optional<double> DepthOfPipe(const Vector3d& ray_S, const CylinderFit& pipe, double lo_m,
                                  double hi_m) {
  const Vector3d a = ray_S - pipe.l_S.dot(ray_S) * pipe.l_S;
  const Vector3d c = pipe.p_S - pipe.l_S.dot(pipe.p_S) * pipe.l_S;
  const double A = a.squaredNorm();
  const double B = a.dot(c);
  const double C = c.squaredNorm() - pipe.radius_m * pipe.radius_m;
  const double discriminant = B * B - A * C;
  if (!(discriminant > 0) || A < 1e-12 || C <= 0) {
    return std::nullopt;
  }
  const double z = (B - std::sqrt(discriminant)) / A;
  const double s = pipe.l_S.dot(z * ray_S - pipe.p_S);
  if (!(z > 0) || s < lo_m || s > hi_m) {
    return std::nullopt;
  }
  return z;
}

void PipeFinder::Find(DepthView& view, std::span<const CylinderFit> hints) {
  found_.clear();
  Gather(view);
  Sample();
  for (const CylinderFit& hint : hints) {
    if (samples_ > 0) {
      Consider(view, {hint, Score(hint)});
    }
  }
  for (int attempt = 0; attempt < kAttempts && !found_.full(); ++attempt) {
    Sample();
    const Hypothesis best = Draw(view);
    if (best.score < 5) {
      return;
    }
    if (!Consider(view, best)) {
      Bar(best.pipe);
    }
  }
}

/// The readings that may be of a pipe: in range, of no plane, with a normal.
void PipeFinder::Gather(const DepthView& view) {
  readings_ = 0;
  for (int i = 0; i < view.size(); ++i) {
    reading_of_[i] = -1;
    if (view.use(i) != DepthView::Use::kFree ||
        view.inverse_z(i) * static_cast<float>(config_.pipe_range_m) < 1) {
      continue;
    }
    if (const std::optional<Eigen::Vector3f> n = view.Normal(i)) {
      reading_[readings_] = {i, view.p_S(i), *n};
      reading_of_[i] = static_cast<std::int16_t>(readings_);
      barred_[readings_] = 0;
      ++readings_;
    }
  }
}

void PipeFinder::Sample() {
  int free = 0;
  for (int k = 0; k < readings_; ++k) {
    free += barred_[k] == 0;
  }
  samples_ = 0;
  if (free < config_.pipe_min_points) {
    return;
  }
  const int step = 1 + free / kMaxSamples;
  int count = 0;
  for (int k = 0; k < readings_; ++k) {
    if (barred_[k] == 0 && count++ % step == 0 && samples_ < kMaxSamples) {
      sample_[samples_++] = k;
    }
  }
}

bool PipeFinder::Agrees(const Reading& reading, const CylinderFit& pipe, double& s_m) const {
  const Vector3d p = reading.p_S.cast<double>();
  const Vector3d w = p - pipe.p_S;
  s_m = pipe.l_S.dot(w);
  const Vector3d across = w - s_m * pipe.l_S;
  const double rho = std::sqrt(across.squaredNorm());
  if (std::abs(s_m) > kReach_m || rho < 1e-6 || std::abs(rho - pipe.radius_m) > 0.1) {
    return false;
  }
  const Vector3d g = across / rho;
  const double limit = config_.inlier_sigmas * SurfaceSigma(p, g, config_.noise) + kSlack_m;
  return std::abs(rho - pipe.radius_m) < limit && reading.n_S.dot(g.cast<float>()) > kNormalAgrees;
}

int PipeFinder::Score(const CylinderFit& pipe) const {
  int score = 0;
  double s_m = 0;
  for (int k = 0; k < samples_; ++k) {
    score += Agrees(reading_[sample_[k]], pipe, s_m);
  }
  return score;
}

/// Readings about `seed` in the image and in space, thinned to kMaxPatch.
int PipeFinder::Patch(const DepthView& view, int seed) {
  const Reading& center = reading_[seed];
  const int reach =
      std::clamp(static_cast<int>(kPatch_m * view.focal() / center.p_S.z()), 2, view.width() / 4);
  const int step = 1 + (2 * reach + 1) * (2 * reach + 1) / (2 * kMaxPatch);
  const int column = center.pixel % view.width();
  const int row = center.pixel / view.width();
  int count = 0;
  int passed = 0;
  for (int r = std::max(0, row - reach); r <= std::min(view.height() - 1, row + reach); ++r) {
    for (int c = std::max(0, column - reach); c <= std::min(view.width() - 1, column + reach);
         ++c) {
      const int k = reading_of_[r * view.width() + c];
      if (k < 0 || barred_[k] != 0 || passed++ % step != 0 || count == kMaxPatch ||
          (reading_[k].p_S - center.p_S).squaredNorm() > kPatch_m * kPatch_m) {
        continue;
      }
      patch_[count++] = k;
    }
  }
  return count;
}

/// The circle across l through the patch (least squares, algebraic): x² + y² + Dx + Ey + F = 0.
bool PipeFinder::FromDirection(const Vector3d& l_S, int patch, CylinderFit& pipe) const {
  const Vector3d e1 = l_S.unitOrthogonal();
  const Vector3d e2 = l_S.cross(e1);
  const Vector3d origin = reading_[patch_[0]].p_S.cast<double>();
  Matrix3d N = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (int k = 0; k < patch; ++k) {
    const Vector3d w = reading_[patch_[k]].p_S.cast<double>() - origin;
    const Vector3d row{e1.dot(w), e2.dot(w), 1};
    const double square = row.head<2>().squaredNorm();
    N += row * row.transpose();
    b -= square * row;
  }
  const Vector3d DEF = N.ldlt().solve(b);
  const double cx = -DEF.x() / 2;
  const double cy = -DEF.y() / 2;
  const double r2 = cx * cx + cy * cy - DEF.z();
  if (!DEF.allFinite() || !(r2 > 0)) {
    return false;
  }
  pipe.l_S = l_S;
  pipe.p_S = origin + cx * e1 + cy * e2;
  pipe.radius_m = std::sqrt(r2);
  return pipe.radius_m > config_.pipe_radius_min_m / 2 &&
         pipe.radius_m < config_.pipe_radius_max_m * 1.5;
}

void PipeFinder::Keep(const CylinderFit& pipe, Hypothesis& best) const {
  if (const int score = Score(pipe); score > best.score) {
    best = {pipe, score};
  }
}

PipeFinder::Hypothesis PipeFinder::Draw(const DepthView& view) {
  Hypothesis best;
  for (int draw = 0; draw < config_.pipe_draws && samples_ > 0; ++draw) {
    const int count = Patch(view, sample_[rng_.Index(samples_)]);
    if (count < kMinPatch) {
      continue;
    }
    Matrix3d normals = Matrix3d::Zero();
    Matrix3d spread = Matrix3d::Zero();
    Vector3d mean = Vector3d::Zero();
    for (int k = 0; k < count; ++k) {
      mean += reading_[patch_[k]].p_S.cast<double>() / count;
    }
    for (int k = 0; k < count; ++k) {
      const Vector3d n = reading_[patch_[k]].n_S.cast<double>();
      const Vector3d w = reading_[patch_[k]].p_S.cast<double>() - mean;
      normals += n * n.transpose() / count;
      spread += w * w.transpose() / count;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> of_normals(normals);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> of_spread(spread);
    if (of_normals.eigenvalues()(1) < kMinCurvature) {
      continue;
    }
    CylinderFit pipe;
    if (FromDirection(of_normals.eigenvectors().col(0), count, pipe)) {
      Keep(pipe, best);
    }
    if (FromDirection(of_spread.eigenvectors().col(2), count, pipe)) {
      Keep(pipe, best);
    }
  }
  return best;
}

}  // namespace pipewright
