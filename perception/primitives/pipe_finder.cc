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
constexpr double kMinCurvature = 0.01;  // second eigenvalue of the normals: less is flat

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
    if (sampled_.size() > 0) {
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
  constexpr int kRun = 64;
  std::array<Eigen::Vector3f, kRun> n_S;
  const auto range_m = static_cast<float>(config_.pipe_range_m);
  const auto wanted = [&](int i) {
    return view.use(i) == DepthView::Use::kFree && view.inverse_z(i) * range_m >= 1;
  };
  reading_.clear();
  std::fill_n(reading_of_.begin(), view.size(), std::int16_t{-1});
  for (int i = 0; i < view.size();) {
    const int row_end = (i / view.width() + 1) * view.width();
    int end = i;
    while (end < row_end && end - i < kRun && wanted(end)) {
      ++end;
    }
    view.Normals(i, end, n_S.data());
    for (int j = i; j < end; ++j) {
      if (const Eigen::Vector3f& n = n_S[j - i]; n != Eigen::Vector3f::Zero()) {
        reading_of_[j] = static_cast<std::int16_t>(reading_.size());
        barred_[reading_.size()] = 0;
        pixel_[reading_.size()] = j;
        reading_.push_back(view.p_S(j), n, 1 / (view.inverse_z(j) * view.inverse_sigma(j)));
      }
    }
    i = std::max(end, i + 1);
  }
  reading_.Close();
}

void PipeFinder::Sample() {
  sampled_.clear();
  const auto free =
      static_cast<int>(std::count(barred_.begin(), barred_.begin() + reading_.size(), 0));
  if (free < config_.pipe_min_points) {
    return;
  }
  const int step = 1 + free / kMaxSamples;
  int count = 0;
  for (int k = 0; k < reading_.size(); ++k) {
    if (barred_[k] == 0 && count++ % step == 0 && sampled_.size() < kMaxSamples) {
      sample_[sampled_.size()] = k;
      sampled_.push_back(reading_, k);
    }
  }
  sampled_.Close();
}

int PipeFinder::Score(const CylinderFit& pipe) const {
  const PipeAxis axis(pipe);
  const auto sigmas = static_cast<float>(config_.inlier_sigmas);
  Masks score{};
  Floats s_m;
  for (int k = 0; k < sampled_.size(); k += kLanes) {
    score -= sampled_.Agree(k, axis, sigmas, s_m);
  }
  return Sum(score);
}

/// Readings about `seed` in the image and in space, thinned to kMaxPatch.
int PipeFinder::Patch(const DepthView& view, int seed) {
  const Eigen::Vector3f center = reading_.p_S(seed);
  const int reach =
      std::clamp(static_cast<int>(kPatch_m * view.focal() / center.z()), 2, view.width() / 4);
  const int step = 1 + (2 * reach + 1) * (2 * reach + 1) / (2 * kMaxPatch);
  const int column = pixel_[seed] % view.width();
  const int row = pixel_[seed] / view.width();
  int count = 0;
  int passed = 0;
  for (int r = std::max(0, row - reach); r <= std::min(view.height() - 1, row + reach); ++r) {
    for (int c = std::max(0, column - reach); c <= std::min(view.width() - 1, column + reach);
         ++c) {
      const int k = reading_of_[r * view.width() + c];
      if (k < 0 || passed++ % step != 0 || count == kMaxPatch ||
          (reading_.p_S(k) - center).squaredNorm() > kPatch_m * kPatch_m) {
        continue;
      }
      patch_[count++] = k;
    }
  }
  return count;
}

bool PipeFinder::FromDirection(const Vector3d& l_S, int patch, CylinderFit& pipe) {
  for (int k = 0; k < patch; ++k) {
    point_[k] = reading_.p_S(patch_[k]);
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
  for (int draw = 0; draw < config_.pipe_draws && sampled_.size() > 0; ++draw) {
    const int count = Patch(view, sample_[rng_.Index(sampled_.size())]);
    if (count < kMinPatch) {
      continue;
    }
    Matrix3d normals = Matrix3d::Zero();
    Matrix3d spread = Matrix3d::Zero();
    Vector3d mean = Vector3d::Zero();
    for (int k = 0; k < count; ++k) {
      mean += reading_.p_S(patch_[k]).cast<double>() / count;
    }
    for (int k = 0; k < count; ++k) {
      const Vector3d n = reading_.n_S(patch_[k]).cast<double>();
      const Vector3d w = reading_.p_S(patch_[k]).cast<double>() - mean;
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
