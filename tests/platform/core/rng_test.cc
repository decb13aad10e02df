// SPDX-License-Identifier: MIT
#include "platform/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pipewright {
namespace {

TEST(Rng, OneSeedGivesOneSequenceAndStreamsDiffer) {
  Rng a(7);
  Rng b(7);
  Rng c(7, 1);
  int equal = 0;
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t x = a.Next();
    EXPECT_EQ(x, b.Next());
    equal += x == c.Next();
  }
  EXPECT_EQ(equal, 0);
}

TEST(Rng, NormalHasTheMomentsOfANormal) {
  Rng rng(1);
  constexpr int kDraws = 200'000;
  double sum = 0;
  double sum2 = 0;
  double sum4 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = rng.Normal();
    sum += x;
    sum2 += x * x;
    sum4 += x * x * x * x;
  }
  // Five standard deviations of each sample moment: variances 1, 2 and 96.
  EXPECT_NEAR(sum / kDraws, 0, 5 * std::sqrt(1.0 / kDraws));
  EXPECT_NEAR(sum2 / kDraws, 1, 5 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(sum4 / kDraws, 3, 5 * std::sqrt(96.0 / kDraws));
}

TEST(Rng, IndexReachesEveryValueEvenly) {
  Rng rng(2);
  int count[7] = {};
  for (int i = 0; i < 70'000; ++i) {
    const int k = rng.Index(7);
    ASSERT_GE(k, 0);
    ASSERT_LT(k, 7);
    ++count[k];
  }
  for (const int c : count) {
    EXPECT_NEAR(c, 10'000, 5 * std::sqrt(10'000.0));
  }
}

}  // namespace
}  // namespace pipewright
