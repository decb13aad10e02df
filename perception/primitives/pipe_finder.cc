// SPDX-License-Identifier: MIT
#include "perception/primitives/pipe_finder.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "perception/primitives/circle.h"

namespace pipewright {
namespace {

constexpr int kAttempts = 8;       // hypotheses refined a frame
constexpr double kPatch_m = 0.12;  // radius about a draw's reading
constexpr int kMinPatch = 12;
constexpr float kReach_m = 1.5F;        // along the axis from a hypothesis' middle
constexpr double kMinCurvature = 0.01;  // second eigenvalue of the normals: less is flat
constexpr float kNormalAgrees = 0.6F;   // cosine
constexpr float kSlack_m = 0.001F;      // pipes are round to this

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

void PipeFinder::Find(DepthView& view, std::span<const CylinderFit> hints,
                      std::span<const DetectedPlane> planes) {
  found_.clear();
  planes_ = planes;
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
      const float z = 1 / view.inverse_z(i);
      reading_[readings_] = {i, view.p_S(i), *n, z / view.inverse_sigma(i)};
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

/// In single precision: it only chooses, and is asked of every reading again and again.
bool PipeFinder::Agrees(const Reading& reading, const Axis& axis, float& s_m) const {
  const Eigen::Vector3f w = reading.p_S - axis.p_S;
  s_m = axis.l_S.dot(w);
  const Eigen::Vector3f across = w - s_m * axis.l_S;
  const float rho = std::sqrt(across.squaredNorm());
  const float off_m = std::abs(rho - axis.radius_m);
  if (std::abs(s_m) > kReach_m || rho < 1e-6F || off_m > 0.1F ||
      reading.n_S.dot(across) < kNormalAgrees * rho) {
    return false;
  }
  const float towards = std::abs(across.dot(reading.p_S)) / rho;
  const float grazing = static_cast<float>(kGrazing) * std::sqrt(reading.p_S.squaredNorm());
  const float sigma_m = reading.sigma_per_m * std::max(towards, grazing);
  return off_m < static_cast<float>(config_.inlier_sigmas) * sigma_m + kSlack_m;
}

int PipeFinder::Score(const CylinderFit& pipe) const {
  const Axis axis(pipe);
  int score = 0;
  float s_m = 0;
  for (int k = 0; k < samples_; ++k) {
    score += Agrees(reading_[sample_[k]], axis, s_m);
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

bool PipeFinder::FromDirection(const Vector3d& l_S, int patch, CylinderFit& pipe) {
  for (int k = 0; k < patch; ++k) {
    point_[k] = reading_[patch_[k]].p_S;
  }
  return CircleAcross(l_S, {point_.data(), static_cast<std::size_t>(patch)}, pipe) &&
         pipe.radius_m > config_.pipe_radius_min_m / 2 &&
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
