// SPDX-License-Identifier: MIT
#include "perception/localization/scan_localizer.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace pipewright {

ScanLocalizer::ScanLocalizer(const ScanLocalizerConfig& config)
    : config_(config), map_(config.map) {}

/// Of the range: that of z, along the ray.
float ScanLocalizer::Sigma(const Eigen::Vector3f& p_SQ) const {
  return static_cast<float>(config_.range_noise_1pm) * p_SQ.z() * p_SQ.norm();
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

Status ScanLocalizer::Step(const Cloud& cloud, const Isometry3d& X_BS, const Vector3d& guess,
                           PoseFix& fix) {
  ++counters_.scans;
  trusted_ = false;
  const int count = Select(cloud);
  const std::span<const ScanPoint> scan(scan_.data(), static_cast<std::size_t>(count));
  RegistrationConfig config = config_.registration;
  Status status = Register(map_, scan, X_BS, guess, config, fix, figures_);
  if (status == Status::kFault || status == Status::kIterationLimit) {
    config.reach_m = config_.far_reach_m;  // has it slipped?
    status = Register(map_, scan, X_BS, guess, config, fix, figures_);
  }
  fix.stamp = cloud.stamp;
  if (status == Status::kOk) {
    ++counters_.fixes;
    const Vector3d jump = fix.pose - guess;
    trusted_ = jump.head<2>().norm() <= config_.jump_m && std::abs(jump.z()) <= config_.jump_rad;
    if (trusted_) {
      Extend(cloud, BaseAt(fix.pose) * X_BS);
    } else {
      ++counters_.jumps;
    }
  } else if (status == Status::kUnavailable || status == Status::kInfeasible) {
    ++counters_.unknown;
    Extend(cloud, BaseAt(guess) * X_BS);
  } else {
    ++counters_.refused;
  }
  return status;
}

}  // namespace pipewright
