// SPDX-License-Identifier: MIT
#include "hil/report/series.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Sampler, KeepsWhatFits) {
  Sampler sampler(8);
  for (int i = 0; i < 4; ++i) {
    sampler.Add(i, 10 * i);
  }
  const Series s = sampler.Take("x");
  EXPECT_EQ(s.name, "x");
  EXPECT_EQ(s.t_s, (std::vector<double>{0, 1, 2, 3}));
  EXPECT_EQ(s.value, (std::vector<double>{0, 10, 20, 30}));
}

TEST(Sampler, KeepsBothExtremesAtTheirTimesForAnyLength) {
  Rng rng(7);
  for (const int length : {1, 7, 16, 17, 100, 999, 4096, 20011}) {
    SCOPED_TRACE(length);
    Sampler sampler(32);
    double lo = 1e9;
    double hi = -1e9;
    double t_lo = 0;
    double t_hi = 0;
    for (int i = 0; i < length; ++i) {
      const double value = rng.Uniform(-1, 1);
      sampler.Add(i, value);
      if (value < lo) {
        lo = value;
        t_lo = i;
      }
      if (value > hi) {
        hi = value;
        t_hi = i;
      }
    }
    const Series s = sampler.Take("");
    ASSERT_LE(s.value.size(), 32u);
    EXPECT_TRUE(std::is_sorted(s.t_s.begin(), s.t_s.end()));
    const auto at_lo = std::min_element(s.value.begin(), s.value.end()) - s.value.begin();
    const auto at_hi = std::max_element(s.value.begin(), s.value.end()) - s.value.begin();
    EXPECT_EQ(s.value[at_lo], lo);
    EXPECT_EQ(s.t_s[at_lo], t_lo);
    EXPECT_EQ(s.value[at_hi], hi);
    EXPECT_EQ(s.t_s[at_hi], t_hi);
  }
}

TEST(Sampler, IsNeverOffByMoreThanABucketInTime) {
  // A ramp: each kept point lies on it, and no stretch longer than a bucket is without one.
  Sampler sampler(40);
  constexpr int kLength = 10000;
  for (int i = 0; i < kLength; ++i) {
    sampler.Add(i, 3.0 * i);
  }
  const Series s = sampler.Take("");
  double last = 0;
  for (std::size_t i = 0; i < s.value.size(); ++i) {
    EXPECT_EQ(s.value[i], 3 * s.t_s[i]);
    EXPECT_LE(s.t_s[i] - last, 1024);  // 20 buckets of 2^k samples that hold 10000: k <= 10
    last = s.t_s[i];
  }
  EXPECT_EQ(last, kLength - 1);
}

TEST(Sampler, LeavesAGapWhereNothingWasFinite) {
  Sampler sampler(16);
  for (int i = 0; i < 64; ++i) {
    sampler.Add(i, i < 32 ? 1 : i < 48 ? INFINITY : kNan);
  }
  const Series s = sampler.Take("");
  for (std::size_t i = 0; i < s.value.size(); ++i) {
    EXPECT_EQ(std::isfinite(s.value[i]), s.t_s[i] < 32) << s.t_s[i];
  }
  EXPECT_TRUE(std::isnan(s.value.back()));
}

TEST(Sampler, AReadingAmongGapsSurvives) {
  Sampler sampler(8);
  for (int i = 0; i < 1000; ++i) {
    sampler.Add(i, i == 613 ? 5 : kNan);
  }
  const Series s = sampler.Take("");
  EXPECT_EQ(std::count(s.value.begin(), s.value.end(), 5.0), 1);
}

TEST(Decimate, LeavesShortSeriesAsTheyAre) {
  const Series s{"a", {0, 1, 2}, {5, kNan, 6}};
  const Series d = Decimate(s, 4);
  EXPECT_EQ(d.t_s, s.t_s);
  EXPECT_EQ(d.value[2], 6);
}

}  // namespace
}  // namespace pipewright::hil
