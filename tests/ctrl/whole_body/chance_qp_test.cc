// SPDX-License-Identifier: MIT
#include "ctrl/whole_body/chance_qp.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "platform/core/rng.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::RandomDirection;
using test::RandomIn;

const Vector3d kLo{-1, -1, -1};
const Vector3d kHi{1, 1, 1};

struct Problem {
  QuadraticCost cost;
  ConstraintSet set;
  Controls wanted = Controls::Zero();  ///< the unconstrained minimum

  double Cost(const Controls& u) const { return 0.5 * u.dot(cost.H * u) + cost.g.dot(u); }
};

Mat<3, kControls> RandomJacobian(Rng& rng) {
  Mat<3, kControls> J;
  for (int i = 0; i < kControls; ++i) {
    J.col(i) = RandomIn(rng, kLo, kHi);
  }
  return J;
}

/// A chance row that stands in the way of `wanted`, so that it is active at the optimum.
ChanceRow RowInTheWay(Rng& rng, const Controls& wanted, double z, double deviation) {
  ChanceRow row;
  row.J = RandomJacobian(rng);
  const Vector3d towards = (row.J * wanted).normalized();
  const Vector3d n = (-towards + 0.5 * RandomDirection(rng)).normalized();
  PlaneEstimate plane = test::MakePlane(1, RandomIn(rng, kLo, kHi), n, 1, deviation, deviation);
  row.a = -(row.J.transpose() * n);
  row.cone = PlaneCone(plane, plane.p_WCentroid + 0.1 * n, 1);
  row.b = z * std::sqrt(row.cone.c) + rng.Uniform(0.01, 0.05);
  row.limit = row.b;
  row.key = rng.Index(1 << 20);
  return row;
}

void MakeProblem(Rng& rng, double alpha, int rows, double deviation, Problem& p) {
  p.cost.H.setZero();
  for (int i = 0; i < 6; ++i) {
    Controls j;
    for (int k = 0; k < kControls; ++k) {
      j(k) = rng.Normal();
    }
    p.cost.H += j * j.transpose();
  }
  p.cost.H.diagonal().array() += 1.2;
  for (int k = 0; k < kControls; ++k) {
    p.wanted(k) = rng.Uniform(-0.8, 0.8);
  }
  p.cost.g = -(p.cost.H * p.wanted);
  p.set.lb.setConstant(-1);
  p.set.ub.setConstant(1);
  p.set.z = *ChanceQuantile(alpha);
  p.set.chance.clear();
  for (int i = 0; i < rows; ++i) {
    EXPECT_TRUE(p.set.chance.push_back(RowInTheWay(rng, p.wanted, p.set.z, deviation)));
  }
}

double WorstExcess(const ConstraintSet& set, const Controls& u) {
  double worst = -1e9;
  for (const ChanceRow& row : set.chance) {
    worst = std::max(worst, ChanceExcess(row, u, set.z));
  }
  return worst;
}

TEST(ChanceQp, MeetsEveryConeAndNoFeasiblePointIsBetter) {
  static ChanceQp qp(12);
  static Problem p;
  int rounds = 0;
  int fallbacks = 0;
  for (int i = 0; i < 100; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    MakeProblem(rng, 0.99, 8, 0.05, p);
    const ChanceQp::Answer answer = qp.Solve(p.cost, p.set, SvfiMode::kExact, Controls::Zero());
    EXPECT_EQ(answer.stats.status, QpStatus::kOptimal);
    EXPECT_LE(WorstExcess(p.set, answer.u), 1e-6);
    EXPECT_EQ(answer.stats.checked, 8);
    EXPECT_EQ(answer.stats.held, 8);
    EXPECT_EQ(answer.stats.scale, 1);
    rounds += answer.stats.rounds;
    fallbacks += answer.stats.fallbacks;
    const double best = p.Cost(answer.u);
    for (int k = 0; k < 2000; ++k) {
      Controls u = answer.u;
      const double step = std::pow(10, rng.Uniform(-4, 0));
      for (int c = 0; c < kControls; ++c) {
        u(c) = std::clamp(u(c) + step * rng.Normal(), -1.0, 1.0);
      }
      if (WorstExcess(p.set, u) <= 0) {
        EXPECT_GE(p.Cost(u), best - 1e-5);
      }
    }
  }
  EXPECT_LT(rounds, 600);
  EXPECT_EQ(fallbacks, 0);
}

TEST(ChanceQp, FallsBackToTheWorstCaseWhenTheRoundsRunOut) {
  static ChanceQp qp(1);
  static Problem p;
  int fallbacks = 0;
  for (int i = 0; i < 100; ++i) {
    Rng rng(2, i);
    MakeProblem(rng, 0.999, 10, 0.1, p);
    const ChanceQp::Answer answer = qp.Solve(p.cost, p.set, SvfiMode::kExact, Controls::Zero());
    fallbacks += answer.stats.fallbacks;
    EXPECT_LE(answer.stats.rounds, 2);
    EXPECT_LE(WorstExcess(p.set, answer.u), 1e-6);
  }
  EXPECT_GT(fallbacks, 20);
}

TEST(ChanceQp, TheWorstCaseMeetsEveryCone) {
  static ChanceQp qp(8);
  static Problem p;
  for (int i = 0; i < 200; ++i) {
    Rng rng(3, i);
    MakeProblem(rng, 0.99, 6, 0.05, p);
    const ChanceQp::Answer worst = qp.Solve(p.cost, p.set, SvfiMode::kWorstCase, Controls::Zero());
    EXPECT_LE(WorstExcess(p.set, worst.u), 1e-6);
    EXPECT_EQ(worst.stats.rounds, 1);
    const ChanceQp::Answer exact = qp.Solve(p.cost, p.set, SvfiMode::kExact, Controls::Zero());
    EXPECT_LE(p.Cost(exact.u), p.Cost(worst.u) + 1e-5);  // the price of not knowing u
  }
}

TEST(ChanceQp, ThePublishedModeUnderestimatesWhileAccelerating) {
  static ChanceQp qp(8);
  static Problem p;
  int violated = 0;
  for (int i = 0; i < 200; ++i) {
    Rng rng(4, i);
    MakeProblem(rng, 0.99, 4, 0.2, p);
    const ChanceQp::Answer answer =
        qp.Solve(p.cost, p.set, SvfiMode::kPreviousVelocity, Controls::Zero());
    violated += answer.stats.held < answer.stats.checked ? 1 : 0;
  }
  EXPECT_GT(violated, 20);
}

TEST(ChanceQp, WithoutUncertaintyAllModesAgree) {
  static ChanceQp qp(8);
  static Problem p;
  for (int i = 0; i < 50; ++i) {
    Rng rng(5, i);
    MakeProblem(rng, 0.99, 6, 0, p);
    const Controls exact = qp.Solve(p.cost, p.set, SvfiMode::kExact, Controls::Zero()).u;
    for (const SvfiMode mode : {SvfiMode::kPreviousVelocity, SvfiMode::kWorstCase}) {
      EXPECT_LT((qp.Solve(p.cost, p.set, mode, Controls::Zero()).u - exact).norm(), 1e-6);
    }
  }
}

TEST(ChanceQp, GarbageGivesStandingStillAndTheNextCycleIsClean) {
  static ChanceQp qp(8);
  static Problem p;
  Rng rng(6);
  MakeProblem(rng, 0.9, 4, 0.05, p);
  const Controls before = qp.Solve(p.cost, p.set, SvfiMode::kExact, Controls::Zero()).u;
  QuadraticCost broken = p.cost;
  broken.g(3) = std::nan("");
  const ChanceQp::Answer answer = qp.Solve(broken, p.set, SvfiMode::kExact, Controls::Zero());
  EXPECT_EQ(answer.stats.status, QpStatus::kInvalid);
  EXPECT_TRUE(answer.u.isZero(0));
  const Controls after = qp.Solve(p.cost, p.set, SvfiMode::kExact, Controls::Zero()).u;
  EXPECT_LT((after - before).norm(), 1e-6);
}

/// One-sided binomial test at 99%: whether `held` of n draws speaks against a probability of alpha.
bool Refuted(int held, int n, double alpha) {
  return held < n * alpha - 2.326 * std::sqrt(n * alpha * (1 - alpha)) - 0.5;
}

/// (12) as it stands: the true primitive is drawn from N(estimate, Σ), the row is active.
TEST(ChanceQp, PlanesHoldWithTheStatedProbability) {
  static ChanceQp qp(8);
  static Problem p;
  constexpr int kDraws = 10000;
  for (const double alpha : {0.7, 0.9, 0.95, 0.99, 0.999}) {
    for (int i = 0; i < 3; ++i) {
      SCOPED_TRACE(testing::Message() << alpha << ", seed " << i);
      Rng rng(7, i);
      MakeProblem(rng, alpha, 0, 0, p);
      const Vector3d n = RandomDirection(rng);
      const PlaneEstimate plane = test::MakePlane(1, RandomIn(rng, kLo, kHi), n, 1, 0.1, 0.02);
      const Vector3d t = plane.p_WCentroid + 0.3 * n + 0.3 * plane.e1_W;
      constexpr double kSafe_m = 0.1;
      ChanceRow row;
      row.J = RandomJacobian(rng);
      row.a = -(row.J.transpose() * n);
      row.b = row.limit = PointToPlane(t, plane).d_m - kSafe_m;
      row.cone = PlaneCone(plane, t, 1);
      ASSERT_TRUE(p.set.chance.push_back(row));
      p.cost.g = -30 * row.a;  // straight at the plane
      const Controls u = qp.Solve(p.cost, p.set, SvfiMode::kExact, Controls::Zero()).u;
      ASSERT_NEAR(ChanceExcess(row, u, p.set.z), 0, 2e-6) << "not active";
      int held = 0;
      for (int k = 0; k < kDraws; ++k) {
        const double turn[2] = {0.1 * rng.Normal(), 0.1 * rng.Normal()};
        const double shift = 0.02 * rng.Normal();
        const Vector3d dn = turn[0] * plane.e1_W + turn[1] * plane.e2_W;
        const double d = plane.d_m + dn.dot(plane.p_WCentroid) + shift;
        held += (n + dn).dot(row.J * u) >= -((n + dn).dot(t) - d - kSafe_m) ? 1 : 0;
      }
      EXPECT_FALSE(Refuted(held, kDraws, alpha)) << held;
      EXPECT_LT(held, kDraws * alpha + 4 * std::sqrt(kDraws * alpha * (1 - alpha)) + 2)
          << "wasteful";
    }
  }
}

/// Pipes are first order: the share is allowed to differ by what the curvature makes of it.
TEST(ChanceQp, PipesHoldWithAboutTheStatedProbability) {
  static ChanceQp qp(8);
  static Problem p;
  constexpr int kDraws = 10000;
  constexpr double kFirstOrder = 0.01;
  for (const double alpha : {0.7, 0.9, 0.95, 0.99, 0.999}) {
    SCOPED_TRACE(alpha);
    Rng rng(8);
    MakeProblem(rng, alpha, 0, 0, p);
    const PipeEstimate pipe =
        test::MakePipe(1, {0.1, 0.2, 0.3}, RandomDirection(rng), 0.05, 2, 0.01, 0.03);
    const Vector3d t = pipe.p_W + 0.3 * pipe.l_W.unitOrthogonal() + 0.4 * pipe.l_W;
    const AxisDistance distance = PointToPipeAxis(t, pipe, 0);
    constexpr double kSafe_m = 0.1;
    ChanceRow row;
    row.J = RandomJacobian(rng);
    row.a = -(row.J.transpose() * distance.to_axis.gradient_W);
    row.b = row.limit = distance.to_axis.d_m - pipe.radius_m - kSafe_m;
    row.cone = PipeCone(pipe, distance, 1);
    ASSERT_TRUE(p.set.chance.push_back(row));
    p.cost.g = -30 * row.a;
    const Controls u = qp.Solve(p.cost, p.set, SvfiMode::kExact, Controls::Zero()).u;
    ASSERT_NEAR(ChanceExcess(row, u, p.set.z), 0, 2e-6) << "not active";
    int held = 0;
    const Vector3d a = pipe.l_W.unitOrthogonal();
    const Vector3d b = pipe.l_W.cross(a);
    for (int k = 0; k < kDraws; ++k) {
      PipeEstimate truth = pipe;
      truth.p_W += 0.01 * (rng.Normal() * a + rng.Normal() * b);
      truth.l_W = (truth.l_W + 0.03 * (rng.Normal() * a + rng.Normal() * b)).normalized();
      truth.radius_m += 0.005 * rng.Normal();
      const PointDistance d = PointToPipeAxis(t, truth, 0).to_axis;
      held += d.gradient_W.dot(row.J * u) >= -(d.d_m - truth.radius_m - kSafe_m) ? 1 : 0;
    }
    EXPECT_FALSE(Refuted(held, kDraws, alpha - kFirstOrder)) << held;
  }
}

}  // namespace
}  // namespace pipewright
