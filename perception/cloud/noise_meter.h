// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "perception/cloud/cloud.h"

namespace pipewright {

struct NoiseMeterConfig {
  /// σ(z)/z² that the camera is sold with, 1/m. What is measured is not taken for less: noise that
  /// neighbours share does not show.
  double stated_1pm = 3.8e-3;
  double most = 4;         ///< times that
  double smoothing = 0.1;  ///< share of the newest frame
  int points_min = 200;    ///< of a frame, to measure it by
};

constexpr bool Valid(const NoiseMeterConfig& c) {
  return c.stated_1pm > 0 && c.most >= 1 && c.smoothing > 0 && c.smoothing <= 1 && c.points_min > 0;
}

/// How noisy a stereo camera's readings are, by the readings themselves: it depends on the light
/// and the surfaces, and one that is taken for better than it is fits nothing that it sees.
///
/// Along a row of the image a plane's inverse depth d = 1/z is linear, and its noise is that of the
/// disparity, the same at any range, σ(d) = σ(z)/z² = k. So of readings evenly over the image
///
///   e = d_i - (d_(i-1) + d_(i+1))/2,   σ²(e) = 1.5 k²,   k = median|e| / (0.6745 sqrt(1.5))
///
/// without those far beyond what is known of k: edges, and readings that are wrong.
///
/// No heap. Cost: some 2000 readings a frame, tens of us.
class NoiseMeter {
 public:
  explicit NoiseMeter(const NoiseMeterConfig& config = {});

  void Add(const Cloud& cloud);

  /// σ(z)/z², 1/m.
  double k_1pm() const;

 private:
  static constexpr int kSamples = 2048;

  NoiseMeterConfig config_;
  double measured_1pm_;
  std::array<float, kSamples> samples_{};
};

}  // namespace pipewright
