// SPDX-License-Identifier: MIT
#include "perception/localization/scan_localizer.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace pipewright {
namespace {

constexpr int kNormalSpan = 4;   ///< readings
constexpr double kMore = 1.1;    ///< times the points on known surfaces
constexpr double kFarthest = 3;  ///< standard deviations of a guess, to search

/// Normal of the surface about a reading, towards the sensor, from the readings kNormalSpan beside
/// it each way. @returns false where there are none
bool NormalAt(const Cloud& cloud, int i, Eigen::Vector3f& n_S) {
  const int u = i % cloud.width;
  const int v = i / cloud.width;
  if (u < kNormalSpan || u + kNormalSpan >= cloud.width || v < kNormalSpan ||
      v + kNormalSpan >= cloud.height) {
    return false;
  }
  const int below = kNormalSpan * cloud.width;
  for (const int j : {i - kNormalSpan, i + kNormalSpan, i - below, i + below}) {
    if (cloud.valid[j] == 0) {
      return false;
    }
  }
  n_S = (cloud.p_SQ[i + below] - cloud.p_SQ[i - below])
            .cross(cloud.p_SQ[i + kNormalSpan] - cloud.p_SQ[i - kNormalSpan])
            .normalized();
  if (n_S.dot(cloud.p_SQ[i]) > 0) {
    n_S = -n_S;
  }
  return true;
}

/// As far as the grid's steps may have to go.
PoseSearchConfig Within(const Mat<3, 3>& covariance, PoseSearchConfig search) {
  const double way_var = std::max(covariance(0, 0), covariance(1, 1));
  search.way_m = std::min(search.way_m, kFarthest * std::sqrt(way_var));
  search.turn_rad = std::min(search.turn_rad, kFarthest * std::sqrt(covariance(2, 2)));
  return search;
}

}  // namespace

ScanLocalizer::ScanLocalizer(const ScanLocalizerConfig& config)
    : config_(config), map_(config.map), pipes_(config.pipes) {}

/// Of the range: that of z, along the ray.
float ScanLocalizer::Sigma(const Eigen::Vector3f& p_SQ) const {
  return static_cast<float>(config_.range_noise_1pm) * p_SQ.z() * p_SQ.norm();
}

/// Forgets the surfels that points of the scan, taken from there, do not lie on, and refutes the
/// pipes that most of their points do not.
void ScanLocalizer::Repair(std::span<const ScanPoint> scan, const Isometry3d& X_WS) {
  ++counters_.repairs;
  std::array<int, Scene::kMaxPipes> on_more_than_off{};
  for (const ScanPoint& point : scan) {
    const Vector3d p_WQ = X_WS * point.p_SQ.cast<double>();
    Surfel of_pipe;
    const int pipe = pipes_.Find(p_WQ, of_pipe);
    const Surfel* surfel = pipe >= 0 ? &of_pipe : map_.Find(p_WQ);
    if (surfel == nullptr || surfel->n_W.dot(X_WS.linear() * point.n_S.cast<double>()) <
                                 config_.registration.alike_cosine) {
      continue;
    }
    const Misfit misfit =
        MisfitOf(*surfel, point.sigma_m, p_WQ, X_WS.translation(), config_.registration.model_m);
    const bool off = misfit.r_m * misfit.r_m > kInlierSigmas * kInlierSigmas * misfit.var_m2;
    if (pipe >= 0) {
      on_more_than_off[pipe] += off ? -1 : 1;
    } else if (off) {
      map_.Forget(p_WQ);
    }
  }
  for (int pipe = 0; pipe < pipes_.size(); ++pipe) {
    if (on_more_than_off[pipe] < 0) {
      pipes_.Refute(pipe);
    }
  }
}

/// phi at 1 m.
double ScanLocalizer::Reach(const Mat<3, 3>& covariance) const {
  return std::clamp(config_.reach_least_m + config_.reach_sigmas * std::sqrt(covariance.trace()),
                    config_.reach_least_m, config_.reach_most_m);
}

/// Marks the readings of every block of the image that is near enough on the mean. One by one they
/// must not be judged: of a surface at the limit that takes those which noise draws near.
void ScanLocalizer::MarkUsable(const Cloud& cloud) {
  usable_count_ = 0;
  for (int top = 0; top < cloud.height; top += kBlock) {
    for (int left = 0; left < cloud.width; left += kBlock) {
      const int bottom = std::min(top + kBlock, cloud.height);
      const int right = std::min(left + kBlock, cloud.width);
      float sum_m = 0;
      int count = 0;
      for (int v = top; v < bottom; ++v) {
        for (int i = v * cloud.width + left; i < v * cloud.width + right; ++i) {
          sum_m += cloud.valid[i] != 0 ? cloud.p_SQ[i].norm() : 0;
          count += cloud.valid[i] != 0;
        }
      }
      const bool near = sum_m <= static_cast<float>(config_.range_m * count);
      for (int v = top; v < bottom; ++v) {
        for (int i = v * cloud.width + left; i < v * cloud.width + right; ++i) {
          usable_[i] = near && cloud.valid[i] != 0;
        }
      }
      usable_count_ += near ? count : 0;
    }
  }
}

/// Readings evenly over the image, as many as scan_ holds. @returns how many
int ScanLocalizer::Select(const Cloud& cloud) {
  int count = 0;
  int due = 0;
  for (int i = 0; i < cloud.size(); ++i) {
    if (!usable_[i]) {
      continue;
    }
    due += std::min(usable_count_, kScanPoints);  // kScanPoints of all, without bias
    if (due >= usable_count_) {
      due -= usable_count_;
      Eigen::Vector3f n_S;
      if (NormalAt(cloud, i, n_S)) {
        scan_[count++] = {cloud.p_SQ[i], Sigma(cloud.p_SQ[i]), n_S};
      }
    }
  }
  return count;
}

void ScanLocalizer::Extend(const Cloud& cloud, const Isometry3d& X_WS) {
  for (int i = 0; i < cloud.size(); ++i) {
    if (usable_[i]) {
      // A map that is full counts what it refuses.
      static_cast<void>(map_.Add(X_WS * cloud.p_SQ[i].cast<double>(), Sigma(cloud.p_SQ[i]),
                                 X_WS.translation(), placed_));
    }
  }
}

/// Near the guess; one in doubt within the search's grid, if more of the scan fits there.
Status ScanLocalizer::Find(std::span<const ScanPoint> scan, const Isometry3d& X_BS,
                           const BasePose& guess, bool doubted, const Mat<3, 3>& worst,
                           PoseFix& fix) {
  const Vector3d pose(guess.x_m, guess.y_m, guess.phi_rad);
  RegistrationConfig config = config_.registration;
  config.reach_m = Reach(guess.covariance);
  const Status near = Register(map_, pipes_, scan, X_BS, pose, pose, config, fix, figures_);
  if (!doubted) {
    return near;
  }
  const Vector3d start = BestStart(map_, pipes_, scan, X_BS, pose, Within(worst, config_.search));
  config.reach_m = config_.search.width_m;
  PoseFix far_fix;
  RegistrationFigures far_figures;
  const Status far = Register(map_, pipes_, scan, X_BS, pose, start, config, far_fix, far_figures);
  const bool better = near != Status::kOk || far_figures.inliers > kMore * figures_.inliers;
  if (far != Status::kOk || !better) {
    return near;
  }
  fix = far_fix;
  figures_ = far_figures;
  return far;
}

Status ScanLocalizer::Step(const Cloud& cloud, const Isometry3d& X_BS, const BasePose& guess,
                           bool doubted, const Mat<3, 3>& worst, PoseFix& fix) {
  ++counters_.scans;
  added_ = false;
  pose_ = {guess.x_m, guess.y_m, guess.phi_rad};
  const Vector3d before = pose_;
  placed_ = PlacementOf(guess.covariance);
  MarkUsable(cloud);
  const int count = Select(cloud);
  const std::span<const ScanPoint> scan(scan_.data(), static_cast<std::size_t>(count));
  const Status status = Find(scan, X_BS, guess, doubted, worst, fix);
  fix.stamp = cloud.stamp;
  if (status == Status::kOk) {
    ++counters_.fixes;
    Mat<3, 3> M = guess.covariance;
    const Vector3d common = CommonWith(fix.placed, Vector3d::Zero(), M);
    const FixGain gain = GainOf(before, M, fix, common, config_.fix);
    if (gain.within_gate) {
      const Mat<3, 3> MS = M * gain.S_inverse;
      const Mat<3, 3> own = M - MS * M;
      pose_ += MS * gain.y;
      placed_ = PlacementOf(own + Mat<3, 3>(common.asDiagonal()));
    }
    const Vector3d jump = pose_ - before;
    added_ = gain.within_gate && jump.head<2>().norm() <= config_.jump_m &&
             std::abs(jump.z()) <= config_.jump_rad;
    counters_.jumps += added_ ? 0 : 1;
  } else if (status == Status::kUnavailable || status == Status::kInfeasible) {
    ++counters_.unknown;
    added_ = true;
  } else {
    ++counters_.refused;
  }
  const bool nearly =
      doubted && status == Status::kFault && figures_.inlier_share >= config_.misfit_least;
  misfits_ = nearly ? misfits_ + 1 : 0;
  if (misfits_ >= config_.misfits) {
    misfits_ = 0;
    Repair(scan, BaseAt(figures_.pose) * X_BS);
  }
  added_ = added_ && !doubted;
  if (added_) {
    Extend(cloud, BaseAt(pose_) * X_BS);
  }
  return status;
}

}  // namespace pipewright
