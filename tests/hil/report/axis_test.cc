// SPDX-License-Identifier: MIT
#include "hil/report/axis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

TEST(LinearAxis, HoldsItsRangeOnRoundTicks) {
  Rng rng(3);
  for (int i = 0; i < 500; ++i) {
    const double size = std::pow(10.0, rng.Uniform(-6, 6));
    const double lo = size * rng.Uniform(-1, 1);
    const double hi = lo + size * rng.Uniform(0.001, 1);
    const Axis axis = LinearAxis(lo, hi, 5);
    SCOPED_TRACE(testing::Message() << lo << " to " << hi);
    EXPECT_LE(axis.lo, lo + 1e-9 * size);
    EXPECT_GE(axis.hi, hi - 1e-9 * size);
    ASSERT_GE(axis.ticks.size(), 2u);
    ASSERT_LE(axis.ticks.size(), 8u);
    const double step = axis.ticks[1] - axis.ticks[0];
    const double digits = step / std::pow(10.0, std::floor(std::log10(step) + 1e-6));
    const bool round = std::abs(digits - 1) < 1e-6 || std::abs(digits - 2) < 1e-6 ||
                       std::abs(digits - 2.5) < 1e-6 || std::abs(digits - 5) < 1e-6;
    EXPECT_TRUE(round) << digits;
  }
}

TEST(LinearAxis, OfOneValueHasAWidth) {
  for (const double value : {0.0, 3.0, -3.0, 1e-9}) {
    const Axis axis = LinearAxis(value, value, 5);
    EXPECT_LT(axis.lo, axis.hi);
    EXPECT_LE(axis.lo, value);
    EXPECT_GE(axis.hi, value);
  }
}

TEST(LogarithmicAxis, TakesWholeDecades) {
  const Axis axis = LogarithmicAxis(0.02, 700);
  EXPECT_DOUBLE_EQ(axis.lo, 0.01);
  EXPECT_DOUBLE_EQ(axis.hi, 1000);
  EXPECT_EQ(axis.ticks.size(), 6u);
  EXPECT_NEAR(axis.At(1), 0.4, 1e-12);
  EXPECT_EQ(axis.At(1e-30), 0);
  EXPECT_EQ(axis.At(1e30), 1);
}

TEST(LogarithmicAxis, KeepsTheHighestSixDecadesOfMany) {
  const Axis axis = LogarithmicAxis(1e-15, 1);
  EXPECT_DOUBLE_EQ(axis.hi, 1);
  EXPECT_DOUBLE_EQ(axis.lo, 1e-6);
}

TEST(LogarithmicAxis, OfOnePowerOfTenIsOneDecade) {
  const Axis axis = LogarithmicAxis(10, 10);
  EXPECT_DOUBLE_EQ(axis.lo, 1);
  EXPECT_DOUBLE_EQ(axis.hi, 10);
}

TEST(ValueAxis, HoldsZeroAndTheLimitsAndSkipsGaps) {
  Plot plot;
  plot.series = {{"a", {0, 1, 2}, {3, NAN, INFINITY}}};
  plot.limits = {{"limit", 7}, {"unknown", NAN}};
  const Axis axis = ValueAxis(plot);
  EXPECT_EQ(axis.lo, 0);
  EXPECT_GE(axis.hi, 7);
  EXPECT_LT(axis.hi, 20);
}

TEST(ValueAxis, EndsAtTheCeiling) {
  const Plot plot{.title = "t", .series = {{"a", {0, 1}, {0.1, 30}}}, .ceiling = 0.5};
  EXPECT_EQ(ValueAxis(plot).hi, 0.5);
  EXPECT_EQ(ValueAxis(plot).At(30), 1);
}

TEST(ValueAxis, OfLanesHasTicksAtItsEndsAndZero) {
  const Plot plot{.title = "t", .series = {{"a", {0, 1}, {-1.02, 0.9}}}, .lanes = true};
  const Axis axis = ValueAxis(plot);
  EXPECT_EQ(axis.ticks, (std::vector<double>{axis.lo, 0, axis.hi}));
  EXPECT_EQ(axis.lo, -1.25);
  EXPECT_EQ(axis.hi, 1);
}

TEST(ValueAxis, OfAPlotWithoutValuesExists) {
  Plot plot;
  EXPECT_LT(ValueAxis(plot).lo, ValueAxis(plot).hi);
  plot.scale = PlotScale::kLogarithmic;
  plot.series = {{"a", {0, 1}, {0, -1}}};
  EXPECT_LT(ValueAxis(plot).lo, ValueAxis(plot).hi);
}

}  // namespace
}  // namespace pipewright::hil
