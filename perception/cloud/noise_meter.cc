// SPDX-License-Identifier: MIT
#include "perception/cloud/noise_meter.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace pipewright {
namespace {

constexpr double kMedianOfNormal = 0.6745;  ///< of |x|, in standard deviations
constexpr double kVarianceOfBend = 1.5;     ///< 1 + 2/4
constexpr double kGate = 5;                 ///< standard deviations; more is an edge

}  // namespace

NoiseMeter::NoiseMeter(const NoiseMeterConfig& config)
    : config_(config), measured_1pm_(config.stated_1pm) {
  assert(Valid(config));
}

void NoiseMeter::Add(const Cloud& cloud) {
  const int step = std::max(1, cloud.size() / kSamples);
  const double no_noise = kGate * std::sqrt(kVarianceOfBend) * k_1pm();
  int count = 0;
  for (int i = 1; i + 1 < cloud.size() && count < kSamples; i += step) {
    const int u = i % cloud.width;
    if (u == 0 || u + 1 == cloud.width || cloud.valid[i - 1] == 0 || cloud.valid[i] == 0 ||
        cloud.valid[i + 1] == 0) {
      continue;
    }
    const auto d = [&cloud](int k) { return 1 / cloud.p_SQ[k].z(); };
    const float e = std::abs(d(i) - (d(i - 1) + d(i + 1)) / 2);
    if (e < no_noise) {
      samples_[count++] = e;
    }
  }
  if (count < config_.points_min) {
    return;
  }
  const auto median = samples_.begin() + count / 2;
  std::nth_element(samples_.begin(), median, samples_.begin() + count);
  const double k = *median / (kMedianOfNormal * std::sqrt(kVarianceOfBend));
  if (std::isfinite(k)) {
    measured_1pm_ += config_.smoothing * (k - measured_1pm_);
  }
}

double NoiseMeter::k_1pm() const {
  return std::clamp(measured_1pm_, config_.stated_1pm, config_.most * config_.stated_1pm);
}

}  // namespace pipewright
