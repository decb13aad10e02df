// SPDX-License-Identifier: MIT
#include "plan/motion/edge.h"

#include <gtest/gtest.h>

#include <numbers>

#include "platform/core/rng.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

Configuration Random(Rng& rng) {
  Configuration q;
  for (int i = 0; i < kDof; ++i) {
    q(i) = rng.Uniform(-3, 3);
  }
  return q;
}

Configuration At(double x_m, double y_m, double phi_rad) {
  Configuration q = Configuration::Zero();
  q.head<3>() << x_m, y_m, phi_rad;
  return q;
}

double Difference(const Configuration& a, const Configuration& b) {
  Configuration d = a - b;
  d(2) = WrapAngle(d(2));
  return d.cwiseAbs().maxCoeff();
}

TEST(Edge, BeginsAndEndsWhereItShould) {
  Rng rng(41);
  for (int trial = 0; trial < 200; ++trial) {
    const Configuration a = Random(rng);
    const Configuration b = Random(rng);
    EXPECT_EQ(EdgeAt(a, b, 0), a);
    EXPECT_LT(Difference(EdgeAt(a, b, 1), b), 1e-12);
    EXPECT_LT(Difference(EdgeAt(a, a, 0.3), a), 1e-15);
    EXPECT_EQ(EdgeAt(a, b, -1), EdgeAt(a, b, 0));
    EXPECT_EQ(EdgeAt(a, b, 2), EdgeAt(a, b, 1));
  }
}

TEST(Edge, NeverMovesTheBaseSideways) {
  constexpr double kDs = 1e-4;
  Rng rng(42);
  for (int trial = 0; trial < 100; ++trial) {
    const Edge edge(Random(rng), Random(rng));
    for (double s = 0; s < 1; s += 0.01) {
      const Configuration q = edge.At(s);
      const Configuration step = edge.At(s + kDs) - q;
      EXPECT_LT(std::abs(-std::sin(q(2)) * step(0) + std::cos(q(2)) * step(1)), 2e-3 * kDs)
          << "a step over a corner turns by less than 1e-3";
    }
  }
}

TEST(Edge, TheRateIsTheDerivative) {
  constexpr double kDs = 1e-6;
  Rng rng(43);
  for (int trial = 0; trial < 100; ++trial) {
    const Edge edge(Random(rng), Random(rng));
    for (double s = 0.0005; s < 1; s += 0.01) {
      const Configuration q = edge.At(s);
      const Configuration slope = (edge.At(s + kDs) - edge.At(s - kDs)) / (2 * kDs);
      const Controls rate = edge.RateAt(s);
      if (std::abs(s - edge.s_turned()) < kDs || std::abs(s - edge.s_driven()) < kDs) {
        continue;  // a corner has two slopes
      }
      EXPECT_NEAR(std::cos(q(2)) * slope(0) + std::sin(q(2)) * slope(1), rate(0), 1e-6);
      EXPECT_NEAR(slope(2), rate(1), 1e-6);
      EXPECT_LT((slope.tail<7>() - rate.tail<7>()).cwiseAbs().maxCoeff(), 1e-6);
    }
  }
}

TEST(Edge, NothingIsFasterThanItsSpeed) {
  EdgeSpeeds speeds;
  speeds.drive_mps = 0.3;
  speeds.turn_radps = 0.7;
  speeds.joint_radps = ArmVector::LinSpaced(0.5, 1.5);
  Rng rng(44);
  for (int trial = 0; trial < 100; ++trial) {
    const Edge edge(Random(rng), Random(rng), speeds);
    double most = 0;
    for (double s = 0.0005; s < 1; s += 0.001) {
      const Controls u = edge.RateAt(s) / edge.duration_s();
      most = std::max({most, std::abs(u(0)) / speeds.drive_mps, std::abs(u(1)) / speeds.turn_radps,
                       u.tail<7>().cwiseAbs().cwiseQuotient(speeds.joint_radps).maxCoeff()});
    }
    EXPECT_NEAR(most, 1, 1e-9) << "the slowest of them sets the time";
  }
}

TEST(Edge, DrivesBackwardsWhenThatTurnsLess) {
  struct Case {
    const char* name;
    Configuration a;
    Configuration b;
    double drive_m;
    double turn_rad;
  };
  constexpr double kPi = std::numbers::pi;
  const Case cases[] = {
      {"straight ahead", At(0, 0, 0), At(1, 0, 0), 1, 0},
      {"straight back", At(0, 0, 0), At(-1, 0, 0), -1, 0},
      {"to the side", At(0, 0, 0), At(0, 1, 0), 1, kPi},
      {"behind, and turned about", At(0, 0, 0), At(-1, 0, kPi), 1, kPi},
      {"turn on the spot, over the seam", At(0, 0, 3), At(0, 0, -3), 0, 2 * kPi - 6},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Edge edge(c.a, c.b);
    double most = 0;
    for (double s = 0.005; s < 1; s += 0.01) {
      const double v = edge.RateAt(s)(0);
      most = std::abs(v) > std::abs(most) ? v : most;
    }
    EXPECT_NEAR(edge.drive_m(), std::abs(c.drive_m), 1e-12);
    EXPECT_EQ(most > 0, c.drive_m > 0);
    EXPECT_NEAR(edge.turn_rad(), c.turn_rad, 1e-12);
  }
}

TEST(Edge, APartOfAnEdgeIsTheEdgeToThere) {
  Rng rng(45);
  for (int trial = 0; trial < 200; ++trial) {
    const Configuration a = Random(rng);
    const Edge whole(a, Random(rng));
    const double s_mid = rng.Uniform(0.05, 1);
    const Edge part(a, whole.At(s_mid));
    EXPECT_NEAR(part.duration_s(), s_mid * whole.duration_s(), 1e-6);
    for (double s = 0; s <= 1; s += 0.1) {
      EXPECT_LT(Difference(part.At(s), whole.At(s * s_mid)), 1e-6);
    }
  }
}

TEST(Edge, StepsBoundEveryMotionBetweenChecks) {
  Rng rng(46);
  for (int trial = 0; trial < 100; ++trial) {
    const Edge edge(Random(rng), Random(rng));
    const int steps = edge.Steps(0.02, 0.05);
    for (int i = 0; i < steps; ++i) {
      const Configuration d = edge.At(1.0 * (i + 1) / steps) - edge.At(1.0 * i / steps);
      EXPECT_LE(d.head<2>().norm(), 0.02 + 1e-9);
      EXPECT_LE(d.tail<8>().cwiseAbs().maxCoeff(), 0.05 + 1e-9);
    }
  }
}

TEST(Edge, SpeedsAreTheRobots) {
  const EdgeSpeeds speeds = SpeedsOf(TracerUf7());
  EXPECT_EQ(speeds.drive_mps, TracerUf7().base.speed_mps);
  EXPECT_EQ(speeds.turn_radps, TracerUf7().base.turn_radps);
  EXPECT_EQ(speeds.joint_radps(6), TracerUf7().arm.joints[6].speed_radps);
}

TEST(WrapAngle, LiesInTheHalfOpenTurn) {
  constexpr double kPi = std::numbers::pi;
  EXPECT_EQ(WrapAngle(kPi), kPi);
  EXPECT_EQ(WrapAngle(-kPi), kPi);
  EXPECT_NEAR(WrapAngle(7 * kPi / 2), -kPi / 2, 1e-12);
  EXPECT_EQ(WrapAngle(1), 1);
}

}  // namespace
}  // namespace pipewright
