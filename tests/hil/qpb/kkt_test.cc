// SPDX-License-Identifier: MIT
#include "hil/qpb/kkt.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/qpb_file.h"

namespace pipewright::hil {
namespace {

QpbPoint Optimum() {
  return {.x = {-0.75, 2, 0.25}, .nu = {-2}, .lambda = {0.75, 0}, .mu = {0, 0, 0}};
}

double ResidualAt(const QpbPoint& at) { return KktResidual(test::SoftProblem(), at); }

TEST(KktResidual, IsZeroAtTheOptimum) { EXPECT_EQ(ResidualAt(Optimum()), 0); }

TEST(KktResidual, SeesEveryWayToBeWrong) {
  const struct {
    const char* what;
    void (*spoil)(QpbPoint&);
    double at_least;
  } cases[] = {
      {"x off the minimum", [](QpbPoint& at) { at.x[0] += 0.1; }, 0.03},
      {"x off an equality", [](QpbPoint& at) { at.x[1] += 0.1; }, 0.04},
      {"a slack too small", [](QpbPoint& at) { at.x[2] -= 0.1; }, 0.09},
      {"a slack too large", [](QpbPoint& at) { at.x[2] += 0.1; }, 0.09},
      {"a multiplier of an equality", [](QpbPoint& at) { at.nu[0] = 0; }, 0.9},
      {"a multiplier too small", [](QpbPoint& at) { at.lambda[0] -= 0.1; }, 0.04},
      {"one of a row that is not touched", [](QpbPoint& at) { at.lambda[1] = 0.1; }, 0.04},
      {"one of a bound that is not there", [](QpbPoint& at) { at.mu[0] = 0.1; }, 0.04},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    QpbPoint at = Optimum();
    c.spoil(at);
    EXPECT_GT(ResidualAt(at), c.at_least);
    EXPECT_LT(ResidualAt(at), 2);
  }
}

TEST(KktResidual, TellsAMultiplierOfTheWrongSignFromARightOne) {
  QpbProblem p = test::InfeasibleProblem();  // its rows alone: 2 <= x0 <= 3
  p.Ai = {1};
  p.l = {2};
  p.u = {3};
  QpbPoint at{.x = {2}, .nu = {}, .lambda = {-2}, .mu = {0}};
  EXPECT_EQ(KktResidual(p, at), 0);
  p.g = {-4};  // pulls to 4, but the multiplier holds x0 at its lower side
  at.lambda = {2};
  EXPECT_GT(KktResidual(p, at), 0.2);
  at = {.x = {3}, .nu = {}, .lambda = {1}, .mu = {0}};
  EXPECT_EQ(KktResidual(p, at), 0);
}

TEST(KktResidual, DoesNotGrowWithTheUnitsOfTheCost) {
  QpbProblem p = test::SoftProblem();
  for (double& h : p.H) {
    h *= 1e8;
  }
  QpbPoint at = Optimum();
  at.nu[0] *= 1e8;
  at.lambda[0] *= 1e8;
  EXPECT_EQ(KktResidual(p, at), 0);
  at.nu[0] *= 1 + 1e-9;
  EXPECT_LT(KktResidual(p, at), 2e-9);
}

TEST(KktResidual, IsInfiniteWhereSomethingIsNotANumber) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double bad : {kNan, kInf}) {
    QpbPoint at = Optimum();
    at.x[1] = bad;
    EXPECT_EQ(ResidualAt(at), kInf);
    at = Optimum();
    at.lambda[0] = bad;
    EXPECT_EQ(ResidualAt(at), kInf);
  }
}

}  // namespace
}  // namespace pipewright::hil
