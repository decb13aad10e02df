// SPDX-License-Identifier: MIT
#include "perception/cloud/noise_meter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "platform/core/rng.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

constexpr int kWidth = 106;
constexpr int kHeight = 60;
constexpr double kFocal_px = 56;

/// What of a frame is not a plane seen well.
struct Trouble {
  int step_every = 1000;  ///< columns from one edge of 0.3 m to the next
  double wrong = 0;       ///< share of readings that are anything
  double missing = 0;     ///< share that is not there
  double quantum_m = 0;   ///< depth is rounded to it
};

/// A tilted wall whose readings err by σ(z) = k z².
void See(double k_1pm, const Trouble& trouble, Rng& rng, Cloud& cloud) {
  cloud.width = kWidth;
  cloud.height = kHeight;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const int u = i % kWidth;
    const Vector3d ray((u - kWidth / 2) / kFocal_px, (i / kWidth - kHeight / 2) / kFocal_px, 1);
    const double flat = 1.4 / Vector3d(0.3, -0.2, 1).normalized().dot(ray);
    const double z = flat + 0.3 * (u / trouble.step_every % 2);
    double read = z + k_1pm * z * z * rng.Normal();
    read = rng.Uniform() < trouble.wrong ? rng.Uniform(0.3, 3) : read;
    if (trouble.quantum_m > 0) {
      read = trouble.quantum_m * std::round(read / trouble.quantum_m);
    }
    cloud.p_SQ[i] = (read * ray).cast<float>();
    cloud.valid[i] = rng.Uniform() >= trouble.missing;
  }
}

class NoiseMeterTest : public testing::Test {
 protected:
  double Measure(double k_1pm, const Trouble& trouble = {}, int frames = 80) {
    NoiseMeter meter;
    for (int n = 0; n < frames; ++n) {
      See(k_1pm, trouble, rng_, *cloud_);
      const test::NoAllocScope no_heap;
      meter.Add(*cloud_);
    }
    return meter.k_1pm();
  }

  static constexpr double kStated = NoiseMeterConfig{}.stated_1pm;
  Rng rng_{11};
  std::unique_ptr<Cloud> cloud_ = std::make_unique<Cloud>();
};

TEST_F(NoiseMeterTest, FindsTheNoiseOfAWall) {
  for (const double factor : {1.2, 1.5, 2.0, 3.0}) {
    EXPECT_NEAR(Measure(factor * kStated), factor * kStated, 0.04 * factor * kStated) << factor;
  }
}

TEST_F(NoiseMeterTest, AndAmongEdgesWrongReadingsAndHoles) {
  const double k = 1.5 * kStated;
  EXPECT_NEAR(Measure(k, {.step_every = 7}), k, 0.1 * k);
  EXPECT_NEAR(Measure(k, {.wrong = 0.15}), k, 0.15 * k);
  EXPECT_NEAR(Measure(k, {.missing = 0.3}), k, 0.05 * k);
  EXPECT_NEAR(Measure(k, {.quantum_m = 1e-3}), k, 0.05 * k);
}

TEST_F(NoiseMeterTest, IsNeverSurerThanTheCameraIsSoldFor) {
  EXPECT_EQ(NoiseMeter().k_1pm(), kStated);
  EXPECT_EQ(Measure(0), kStated);
  EXPECT_EQ(Measure(0.5 * kStated), kStated);
}

TEST_F(NoiseMeterTest, HasAnEnd) {
  EXPECT_LE(Measure(20 * kStated), NoiseMeterConfig{}.most * kStated);
}

TEST_F(NoiseMeterTest, LearnsNothingFromAFrameWithoutReadings) {
  EXPECT_EQ(Measure(3 * kStated, {.missing = 1}), kStated);
  NoiseMeter meter;
  cloud_->width = cloud_->height = 0;
  meter.Add(*cloud_);
  EXPECT_EQ(meter.k_1pm(), kStated);
}

}  // namespace
}  // namespace pipewright
