// SPDX-License-Identifier: MIT
#include "perception/primitives/scatter_detector.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "perception/primitives/circle.h"

namespace pipewright {
namespace {

constexpr int kPlaneAttempts = 24;
constexpr int kPipeAttempts = 16;
constexpr int kMinNeighbours = 6;
constexpr int kMinScore = 10;

}  // namespace

void ScatterDetector::Detect(std::span<const Eigen::Vector3f> p_SQ) {
  planes_.clear();
  pipes_.clear();
  Take(p_SQ);
  FindNormals();
  FindPipes();
  FindPlanes();
}

/// Before planes: a strip of a pipe is flat enough for a plane, while planes are never round.
void ScatterDetector::FindPipes() {
  for (int attempt = 0; attempt < kPipeAttempts && !pipes_.full(); ++attempt) {
    DetectedPipe pipe;
    Sample(/*with_normal=*/false);
    if (!DrawPipe(pipe.fit)) {
      break;
    }
    const int center = drawn_from_;
    if (RefinePipe(pipe)) {
      (void)pipes_.push_back(pipe);
      DetectedPipe bounds;
      Bar(CollectPipe(pipe.fit, /*by_normal=*/false, bounds), kUsed);
    } else {
      // Another neighbourhood of the same pipe may lead to it.
      grid_.ForEachNear(p_S_[center],
                        [&](int j) { barred_[j] = barred_[j] == kFree ? kOfNothing : barred_[j]; });
    }
  }
  for (int i = 0; i < points_; ++i) {
    barred_[i] = barred_[i] == kUsed ? kUsed : kFree;  // what led to no pipe may be of a plane
  }
}

void ScatterDetector::FindPlanes() {
  for (int attempt = 0; attempt < kPlaneAttempts && !planes_.full(); ++attempt) {
    DetectedPlane plane;
    Sample(/*with_normal=*/true);
    if (!DrawPlane(plane.fit)) {
      break;
    }
    const PlaneFit drawn = plane.fit;
    const bool found = RefinePlane(plane);
    if (found) {
      (void)planes_.push_back(plane);
    }
    Bar(CollectPlane(found ? plane.fit : drawn), kUsed);
  }
}

/// The finite points, thinned evenly to what there is room for.
void ScatterDetector::Take(std::span<const Eigen::Vector3f> p_SQ) {
  constexpr float kFinest = 16;  // cubes across a neighbourhood
  const auto width_m = static_cast<float>(config_.neighbour_m);
  points_ = thinning_.Pick(p_SQ, width_m / kFinest, index_);
  for (int i = 0; i < points_; ++i) {
    barred_[i] = kFree;
    p_S_[i] = p_SQ[index_[i]];
  }
  grid_.Set({p_S_.data(), static_cast<std::size_t>(points_)}, width_m);
}

/// Of each point, across its neighbours' least spread; none where they are few or not flat.
void ScatterDetector::FindNormals() {
  for (int i = 0; i < points_; ++i) {
    float count = 0;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
    grid_.ForEachNear(p_S_[i], [&](int j) {
      const Eigen::Vector3f w = p_S_[j] - p_S_[i];
      count += 1;
      sum += w;
      squares += w * w.transpose();
    });
    n_S_[i].setZero();
    if (count < kMinNeighbours) {
      continue;
    }
    const Matrix3d spread = (squares - sum * sum.transpose() / count).cast<double>();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(spread);
    constexpr double kFlat = 0.3;  // least over second eigenvalue
    if (eigen.eigenvalues()(0) < kFlat * eigen.eigenvalues()(1)) {
      n_S_[i] = eigen.eigenvectors().col(0).cast<float>();
    }
  }
}

/// Evenly spaced points among those that are left.
void ScatterDetector::Sample(bool with_normal) {
  int free = 0;
  for (int i = 0; i < points_; ++i) {
    index_[free] = i;
    free += barred_[i] == kFree && (!with_normal || n_S_[i] != Eigen::Vector3f::Zero());
  }
  samples_ = std::min(free, kMaxSamples);
  for (int k = 0; k < samples_; ++k) {
    sample_[k] = index_[static_cast<long>(k) * free / samples_];
  }
}

/// Free points about one of them, with their normals.
int ScatterDetector::Patch(int center) {
  int count = 0;
  grid_.ForEachNear(p_S_[center], [&](int j) {
    if (barred_[j] == kFree && count < kMaxPatch) {
      patch_[count] = p_S_[j];
      patch_n_[count++] = n_S_[j];
    }
  });
  return count;
}

void ScatterDetector::Bar(int count, std::uint8_t why) {
  for (int k = 0; k < count; ++k) {
    barred_[index_[k]] = why;
  }
}

/// The triple of points, with normals across it, that most samples agree with.
bool ScatterDetector::DrawPlane(PlaneFit& best) {
  constexpr float kAgrees = 0.9F;
  int most = kMinScore;
  const auto limit_m = static_cast<float>(config_.inlier_sigmas * config_.sigma_m);
  for (int draw = 0; draw < config_.plane_draws && samples_ >= 3; ++draw) {
    const int a = sample_[rng_.Index(samples_)];
    const int b = sample_[rng_.Index(samples_)];
    const int c = sample_[rng_.Index(samples_)];
    const Eigen::Vector3f across = (p_S_[b] - p_S_[a]).cross(p_S_[c] - p_S_[a]);
    const float length = std::sqrt(across.squaredNorm());
    if (length < 1e-3F) {
      continue;
    }
    const Eigen::Vector3f n = across / length;
    const auto agrees = [&](int i) { return std::abs(n.dot(n_S_[i])) > kAgrees; };
    if (!agrees(a) || !agrees(b) || !agrees(c)) {
      continue;
    }
    const float d = n.dot(p_S_[a]);
    int score = 0;
    for (int k = 0; k < samples_; ++k) {
      score += std::abs(n.dot(p_S_[sample_[k]]) - d) < limit_m && agrees(sample_[k]);
    }
    if (score > most) {
      most = score;
      best.n_S = n.cast<double>().normalized();
      best.d_m = d;
    }
  }
  return most > kMinScore;
}

/// Two directions of a neighbourhood, across its normals and along its spread, each with the circle
/// across it: the pipe that most samples agree with.
bool ScatterDetector::DrawPipe(CylinderFit& best) {
  int most = kMinScore;
  int center = 0;
  const auto consider = [&](const Vector3d& l_S, std::span<const Eigen::Vector3f> patch) {
    CylinderFit pipe;
    if (!CircleAcross(l_S, patch, pipe) || pipe.radius_m > 1.5 * config_.pipe_radius_max_m) {
      return;
    }
    int score = 0;
    double s_m = 0;
    for (int k = 0; k < samples_; ++k) {
      score += OnPipe(sample_[k], pipe, /*by_normal=*/true, s_m);
    }
    if (score > most) {
      most = score;
      best = pipe;
      drawn_from_ = center;
    }
  };
  for (int draw = 0; draw < config_.pipe_draws && samples_ > 0; ++draw) {
    center = sample_[rng_.Index(samples_)];
    const int count = Patch(center);
    if (count < kMinNeighbours) {
      continue;
    }
    const std::span<const Eigen::Vector3f> patch(patch_.data(), static_cast<std::size_t>(count));
    Matrix3d normals = Matrix3d::Zero();
    Matrix3d spread = Matrix3d::Zero();
    Vector3d mean = Vector3d::Zero();
    for (const Eigen::Vector3f& p : patch) {
      mean += p.cast<double>() / count;
    }
    for (int k = 0; k < count; ++k) {
      const Vector3d n = patch_n_[k].cast<double>();
      const Vector3d w = patch_[k].cast<double>() - mean;
      normals += n * n.transpose();
      spread += w * w.transpose();
    }
    consider(Eigen::SelfAdjointEigenSolver<Matrix3d>(normals).eigenvectors().col(0), patch);
    consider(Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvectors().col(2), patch);
  }
  return most > kMinScore;
}

}  // namespace pipewright
