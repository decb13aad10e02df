// SPDX-License-Identifier: MIT
// Degenerate, contradictory, unfinished and broken problems: the status must be honest, and no
// solve may leave a trace in the next.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "ctrl/qp/dual_active_set_inl.h"
#include "tests/support/qp_problems.h"

namespace pipewright {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

constexpr int kN = 8;
constexpr int kM = 40;
using Problem = QpProblem<kN, kM>;
using Solver = QpSolver<kN, kM>;

Problem FreeProblem(Rng& rng) {
  Problem qp;
  qp.H = test::RandomHessian<kN>(rng, 100);
  qp.g = test::RandomVec<kN>(rng, 5);
  return qp;
}

Vec<kN> Direction(Rng& rng) { return test::RandomVec<kN>(rng).normalized(); }

void ExpectOptimal(const Problem& qp, const char* what) {
  const auto solver = std::make_unique<Solver>();
  for (const char* start : {"cold", "warm"}) {
    const auto& s = solver->Solve(qp);
    EXPECT_EQ(s.status, QpStatus::kOptimal) << what << ", " << start;
    EXPECT_LT(KktResidual(qp, s), 1e-8) << what << ", " << start;
  }
}

TEST(QpSolver, TakesDuplicateAndNearlyDuplicateRows) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    for (const double apart : {0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3}) {
      Problem qp = FreeProblem(rng);
      for (int i = 0; i < 10; ++i) {
        const Vec<kN> a = Direction(rng);
        const double hi = rng.Uniform(0, 0.3);
        for (int copy = 0; copy < 4; ++copy) {
          (void)qp.AddRow(a + apart * Direction(rng), -kInfinity, hi);
        }
      }
      ExpectOptimal(qp, "duplicates");
    }
  }
}

TEST(QpSolver, TakesAVertexWhereFarMoreRowsMeetThanThereAreVariables) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    Problem qp = FreeProblem(rng);
    const Vec<kN> vertex = test::RandomVec<kN>(rng);
    for (int i = 0; i < kM; ++i) {
      const Vec<kN> a = Direction(rng);
      (void)qp.AddRow(a, -kInfinity, a.dot(vertex));
    }
    ExpectOptimal(qp, "vertex");
  }
}

TEST(QpSolver, TakesThinSets) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    for (const double width : {1e-3, 1e-6, 1e-8}) {
      Problem qp = FreeProblem(rng);
      const Vec<kN> inside = test::RandomVec<kN>(rng);
      for (int i = 0; i < 12; ++i) {
        const Vec<kN> a = Direction(rng);
        (void)qp.AddRow(a, a.dot(inside) - width, a.dot(inside) + width);
      }
      ExpectOptimal(qp, "thin");
    }
  }
}

TEST(QpSolver, TakesDependentEqualitiesAndSeesWhenTheyContradict) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    Problem qp = FreeProblem(rng);
    const Vec<kN> point = test::RandomVec<kN>(rng);
    Vec<kN> basis[3];
    for (Vec<kN>& a : basis) {
      a = Direction(rng);
    }
    for (int i = 0; i < 7; ++i) {
      const Vec<kN> a =
          i < 3 ? basis[i]
                : Vec<kN>(basis[0] * rng.Uniform(-1, 1) + basis[1] * rng.Uniform(-1, 1) +
                          basis[2] * rng.Uniform(-1, 1));
      (void)qp.AddRow(a, a.dot(point), a.dot(point));
    }
    qp.lb[2] = qp.ub[2] = point[2];
    for (int i = 0; i < 10; ++i) {
      const Vec<kN> a = Direction(rng);
      (void)qp.AddRow(a, a.dot(point) - 0.1, a.dot(point) + 0.1);
    }
    ExpectOptimal(qp, "dependent equalities");
    qp.lo[5] = qp.hi[5] += 1e-6;
    Solver solver;
    EXPECT_EQ(solver.Solve(qp).status, QpStatus::kInfeasible);
  }
}

TEST(QpSolver, NamesRowsThatExcludeEachOtherAndNoneTooMany) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    Problem qp = FreeProblem(rng);
    Vec<kN> sum = Vec<kN>::Zero();  // of a few rows, with what they allow: sum'x <= total
    double total = 0;
    const int few = 1 + rng.Index(kN - 1);
    for (int i = 0; i < 20; ++i) {
      const Vec<kN> a = Direction(rng);
      const double hi = rng.Uniform(0, 0.5);
      (void)qp.AddRow(a, -kInfinity, hi);
      if (i < few) {
        const double weight = rng.Uniform(0.2, 1);
        sum += weight * a;
        total += weight * hi;
      }
    }
    const double by = seed % 2 == 0 ? 0.1 : 1e-7;  // a hair is enough
    (void)qp.AddRow(sum, total + by, kInfinity);
    Solver solver;
    const auto& s = solver.Solve(qp);
    ASSERT_EQ(s.status, QpStatus::kInfeasible);
    ASSERT_GE(s.conflict.size(), 2);
    // Those rows alone exclude each other; without any one of them they do not.
    for (int left_out = -1; left_out < s.conflict.size(); ++left_out) {
      Problem part = qp;
      part.ClearRows();
      for (int k = 0; k < s.conflict.size(); ++k) {
        if (k != left_out) {
          const int i = s.conflict[k];
          (void)part.AddRow(qp.A.row(i).transpose(), qp.lo[i], qp.hi[i]);
        }
      }
      Solver fresh;
      EXPECT_EQ(fresh.Solve(part).status,
                left_out < 0 ? QpStatus::kInfeasible : QpStatus::kOptimal);
    }
  }
}

TEST(QpSolver, CallsCrossedLimitsInfeasibleAndNamesThem) {
  Rng rng(1);
  Problem qp = FreeProblem(rng);
  (void)qp.AddRow(Direction(rng), 1, 0.5);
  Solver solver;
  ASSERT_EQ(solver.Solve(qp).status, QpStatus::kInfeasible);
  EXPECT_EQ(solver.Solve(qp).conflict[0], 0);
  qp.ClearRows();
  qp.lb[3] = 1;
  qp.ub[3] = 0;
  ASSERT_EQ(solver.Solve(qp).status, QpStatus::kInfeasible);
  EXPECT_EQ(solver.Solve(qp).conflict[0], kM + 3);
}

TEST(QpSolver, IsHonestHoweverIllConditioned) {
  int optimal = 0;
  for (std::uint64_t seed = 0; seed < 5000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    const double condition = std::pow(10, rng.Uniform(4, 16));
    const auto known = test::MakeQp<kN, kM>(
        {.name = "", .at_lower = 2, .at_bound = 2, .soft = 1, .condition = condition}, seed);
    Solver solver;
    const auto& s = solver.Solve(known.qp);
    ASSERT_NE(s.status, QpStatus::kInfeasible);
    if (s.status == QpStatus::kOptimal) {
      ++optimal;
      EXPECT_LT(KktResidual(known.qp, s), 1e-7);
    } else {
      EXPECT_GT(condition, 1e10);
    }
  }
  EXPECT_GT(optimal, 4000);
}

TEST(QpSolver, DoesNotMindWhatLiesPastTheLastRow) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Problem qp = test::MakeQp<kN, kM>({.name = "", .at_lower = 2, .soft = 1}, seed).qp;
    qp.rows -= 5;
    const Vec<kN> clean = Solver().Solve(qp).x;
    for (int i = qp.rows; i < Problem::kStride; ++i) {
      qp.A.row(i).setConstant(nan);
      qp.lo[i] = nan;
      qp.hi[i] = i % 2 == 0 ? -1e9 : nan;
      qp.price[i] = -1;
    }
    Solver solver;
    const auto& solution = solver.Solve(qp);
    EXPECT_EQ(solution.status, QpStatus::kOptimal) << seed;
    EXPECT_EQ(solution.x, clean) << seed;
  }
}

TEST(QpSolver, IsHonestWhenAPriceIsTooSmallToDivideBy) {
  QpProblem<2, 8> qp;
  ASSERT_TRUE(qp.AddRow(Vec<2>::UnitX(), 1, kInfinity, 5e-321));
  const auto solution = QpSolver<2, 8>().Solve(qp);
  EXPECT_NE(solution.status, QpStatus::kInfeasible);
  if (solution.status == QpStatus::kOptimal) {
    EXPECT_LT(KktResidual(qp, solution), 1e-9);
  }
}

TEST(QpSolver, DoesNotCallAProblemInfeasibleForItsHugeCost) {
  for (double size = 1e3; size < 1e25; size *= 10) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      auto known = test::MakeQp<kN, kM>(
          {.name = "", .at_lower = 2, .at_bound = 2, .soft = 1, .condition = 100}, seed);
      known.qp.g[3] = size;
      EXPECT_NE(Solver().Solve(known.qp).status, QpStatus::kInfeasible) << size << " " << seed;
    }
  }
}

/// The problem of a cap test: 0 satisfies every hard row.
Problem CapProblem(Rng& rng) {
  Problem qp = FreeProblem(rng);
  qp.g *= 20;
  for (int i = 0; i < kM; ++i) {
    const bool soft = i % 5 == 4;
    (void)qp.AddRow(Direction(rng), soft ? 0.5 : -rng.Uniform(0, 1), rng.Uniform(soft ? 0.6 : 0, 1),
                    soft ? 50 : 0);
  }
  qp.lb.setConstant(-0.5);
  qp.ub.setConstant(0.7);
  return qp;
}

double WorstHardViolation(const Problem& qp, const Vec<kN>& x) {
  double worst = std::max((x - qp.ub).maxCoeff(), (qp.lb - x).maxCoeff());
  for (int i = 0; i < qp.rows; ++i) {
    const double y = qp.A.row(i).dot(x);
    worst = qp.price[i] > 0 ? worst : std::max({worst, y - qp.hi[i], qp.lo[i] - y});
  }
  return worst;
}

TEST(QpSolver, StopsAtAPointThatEveryHardRowAllowsWhenCapped) {
  int capped = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Rng rng(seed);
    const Problem qp = CapProblem(rng);
    const Vec<kN> zero = Vec<kN>::Zero();
    const auto reference = std::make_unique<Solver>();
    const Vec<kN> best = reference->Solve(qp).x;
    for (int cap = 1; cap < 30; ++cap) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", cap " << cap);
      const auto solver = std::make_unique<Solver>(QpConfig{.max_iterations = cap});
      const auto& s = solver->Solve(qp, &zero);
      EXPECT_TRUE(s.hard_feasible);
      EXPECT_LE(WorstHardViolation(qp, s.x), 1e-10);
      EXPECT_LE(s.iterations, cap + 1);
      if (s.status == QpStatus::kOptimal) {
        EXPECT_LT((s.x - best).norm(), 1e-9);
        break;
      }
      ASSERT_EQ(s.status, QpStatus::kCapped);
      ++capped;
    }
  }
  EXPECT_GT(capped, 500);
}

TEST(QpSolver, SaysSoWhenNoFeasiblePointIsKnown) {
  Rng rng(3);
  const Problem qp = CapProblem(rng);
  Solver solver({.max_iterations = 2});
  EXPECT_EQ(solver.Solve(qp).status, QpStatus::kCapped);
  EXPECT_FALSE(solver.Solve(qp).hard_feasible);
  for (const double wrong : {5.0, kNan}) {
    const Vec<kN> outside = Vec<kN>::Constant(wrong);
    solver.ForgetActiveSet();
    EXPECT_EQ(solver.Solve(qp, &outside).status, QpStatus::kCapped);
    EXPECT_FALSE(solver.Solve(qp, &outside).hard_feasible);
  }
}

TEST(QpSolver, AnswersWhatIsNotANumberWithAStatusAndForgetsIt) {
  Rng rng(11);
  const Problem good = CapProblem(rng);
  const auto fresh = std::make_unique<Solver>();
  const Vec<kN> expected = fresh->Solve(good).x;
  const auto solver = std::make_unique<Solver>();
  const Vec<kN> zero = Vec<kN>::Zero();
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    for (int field = 0; field < 9; ++field) {
      SCOPED_TRACE(testing::Message() << bad << " in field " << field);
      Problem qp = good;
      double* const spoilt[] = {&qp.H(3, 1), &qp.H(2, 2), &qp.g[4],  &qp.A(39, 7), &qp.A(0, 0),
                                &qp.lo[5],   &qp.hi[6],   &qp.lb[1], &qp.price[3]};
      *spoilt[field] = bad;
      if ((field == 5 || field == 7) && bad == -kInfinity) {
        continue;  // no limit: a lawful problem
      }
      if ((field == 6 || field == 8) && bad == kInfinity) {
        continue;  // no limit; a price beyond all others
      }
      const auto& s = solver->Solve(qp, &zero);
      EXPECT_EQ(s.status, QpStatus::kInvalid);
      EXPECT_TRUE(s.x.allFinite());
      EXPECT_EQ(solver->Solve(good).status, QpStatus::kOptimal);
      EXPECT_EQ(solver->Solve(good).x, solver->Solve(good).x);
      solver->ForgetActiveSet();
      EXPECT_EQ(solver->Solve(good).x, expected);
    }
  }
}

TEST(QpSolver, RefusesACostThatIsNotConvex) {
  Rng rng(12);
  const auto solver = std::make_unique<Solver>();
  Problem qp = CapProblem(rng);
  qp.H(5, 5) = -1;
  EXPECT_EQ(solver->Solve(qp).status, QpStatus::kInvalid);
  qp.H.setZero();
  EXPECT_EQ(solver->Solve(qp).status, QpStatus::kInvalid);
  qp.H.setIdentity();
  qp.price[4] = -1;
  EXPECT_EQ(solver->Solve(qp).status, QpStatus::kInvalid);
  qp.price[4] = 1;
  qp.rows = kM + 1;
  EXPECT_EQ(solver->Solve(qp).status, QpStatus::kInvalid);
}

TEST(QpProblem, SaysWhenItIsFull) {
  QpProblem<2, 3> qp;
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(qp.AddRow(Vec<2>::UnitX(), 0, 1));
  }
  EXPECT_FALSE(qp.AddRow(Vec<2>::UnitX(), 0, 1));
  EXPECT_EQ(qp.rows, 3);
  qp.ClearRows();
  EXPECT_TRUE(qp.AddRow(Vec<2>::UnitX(), 0, 1));
}

}  // namespace
}  // namespace pipewright
