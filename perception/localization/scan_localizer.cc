// SPDX-License-Identifier: MIT
#include "perception/localization/scan_localizer.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace pipewright {

ScanLocalizer::ScanLocalizer(const ScanLocalizerConfig& config)
    : config_(config), map_(config.map), pipes_(config.pipes) {}

/// Of the range: that of z, along the ray.
float ScanLocalizer::Sigma(const Eigen::Vector3f& p_SQ) const {
  return static_cast<float>(config_.range_noise_1pm) * p_SQ.z() * p_SQ.norm();
}

/// phi at 1 m.
double ScanLocalizer::Reach(const Mat<3, 3>& covariance) const {
  return std::clamp(config_.reach_least_m + config_.reach_sigmas * std::sqrt(covariance.trace()),
                    config_.reach_least_m, config_.reach_most_m);
}

/// Readings evenly over the image, as many as scan_ holds. @returns how many
int ScanLocalizer::Select(const Cloud& cloud) {
  int near = 0;
  const auto usable = [&](int i) {
    return cloud.valid[i] != 0 && cloud.p_SQ[i].norm() <= static_cast<float>(config_.range_m);
  };
  for (int i = 0; i < cloud.size(); ++i) {
    near += usable(i);
  }
  int count = 0;
  int due = 0;
  for (int i = 0; i < cloud.size(); ++i) {
    if (!usable(i)) {
      continue;
    }
    due += std::min(near, kScanPoints);  // kScanPoints of each `near`, without bias
    if (due >= near) {
      due -= near;
      scan_[count++] = {cloud.p_SQ[i], Sigma(cloud.p_SQ[i])};
    }
  }
  return count;
}

void ScanLocalizer::Extend(const Cloud& cloud, const Isometry3d& X_WS) {
  for (int i = 0; i < cloud.size(); ++i) {
    if (cloud.valid[i] != 0 && cloud.p_SQ[i].norm() <= static_cast<float>(config_.range_m)) {
      // A map that is full counts what it refuses.
      static_cast<void>(
          map_.Add(X_WS * cloud.p_SQ[i].cast<double>(), Sigma(cloud.p_SQ[i]), X_WS.translation()));
    }
  }
}

Status ScanLocalizer::Step(const Cloud& cloud, const Isometry3d& X_BS, const BasePose& guess,
                           PoseFix& fix) {
  ++counters_.scans;
  trusted_ = false;
  pose_ = {guess.x_m, guess.y_m, guess.phi_rad};
  const Vector3d before = pose_;
  const int count = Select(cloud);
  const std::span<const ScanPoint> scan(scan_.data(), static_cast<std::size_t>(count));
  RegistrationConfig config = config_.registration;
  config.reach_m = Reach(guess.covariance);
  const Status status = Register(map_, pipes_, scan, X_BS, before, config, fix, figures_);
  fix.stamp = cloud.stamp;
  if (status == Status::kOk) {
    ++counters_.fixes;
    const FixGain gain = GainOf(before, guess.covariance, fix, config_.fix);
    if (gain.within_gate) {
      pose_ += guess.covariance * (gain.S_inverse * gain.y);
    }
    const Vector3d jump = pose_ - before;
    trusted_ = gain.within_gate && jump.head<2>().norm() <= config_.jump_m &&
               std::abs(jump.z()) <= config_.jump_rad;
    if (trusted_) {
      Extend(cloud, BaseAt(pose_) * X_BS);
    } else {
      ++counters_.jumps;
    }
  } else if (status == Status::kUnavailable || status == Status::kInfeasible) {
    ++counters_.unknown;
    Extend(cloud, BaseAt(pose_) * X_BS);
  } else {
    ++counters_.refused;
  }
  return status;
}

}  // namespace pipewright
