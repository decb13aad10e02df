// SPDX-License-Identifier: MIT
// The solver against answers that are known before it runs: problems built backwards, brute force
// over all active sets, and the same problem with its slacks written out.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <memory>

#include "ctrl/qp/dual_active_set_inl.h"
#include "tests/support/qp_problems.h"

namespace pipewright {
namespace {

using test::KnownQp;
using test::MakeQp;
using test::QpCase;

constexpr QpCase kCases[] = {
    {.name = "unconstrained"},
    {.name = "one row at its lower limit", .at_lower = 1},
    {.name = "one row at its upper limit", .at_upper = 1},
    {.name = "an equality", .equalities = 1},
    {.name = "a bound", .at_bound = 1},
    {.name = "a violated soft row", .soft = 1},
    {.name = "a vertex of rows", .at_lower = 3, .at_upper = 4, .equalities = 2},
    {.name = "a vertex of bounds", .at_bound = 9},
    {.name = "a vertex of both", .at_lower = 2, .at_upper = 1, .equalities = 1, .at_bound = 5},
    {.name = "more soft rows than variables", .at_upper = 2, .soft = 20},
    {.name = "a bit of all",
     .at_lower = 1,
     .at_upper = 1,
     .equalities = 1,
     .at_bound = 2,
     .soft = 4},
    {.name = "ill conditioned", .at_lower = 2, .at_bound = 2, .soft = 2, .condition = 1e6},
};

TEST(QpSolver, FindsTheSolutionTheProblemWasBuiltFrom) {
  const auto solver = std::make_unique<QpSolver<9, 60>>();
  for (const QpCase& c : kCases) {
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      SCOPED_TRACE(testing::Message() << c.name << ", seed " << seed);
      const KnownQp<9, 60> known = MakeQp<9, 60>(c, seed);
      const QpSolution<9, 60>& s = solver->Solve(known.qp);
      ASSERT_EQ(s.status, QpStatus::kOptimal);
      EXPECT_TRUE(s.hard_feasible);
      EXPECT_LT(KktResidual(known.qp, s), 1e-9);
      EXPECT_LT((s.x - known.x).norm(), 1e-11 * c.condition);
      EXPECT_LT((s.lambda_rows - known.lambda_rows).norm(), 1e-7);
      EXPECT_LT((s.lambda_box - known.lambda_box).norm(), 1e-7);
    }
  }
}

TEST(QpSolver, SolvesTheSizeOfTheController) {
  const auto solver = std::make_unique<QpSolver<kControlQpVariables, kControlQpRows>>();
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto known = MakeQp<kControlQpVariables, kControlQpRows>(kCases[10], seed);
    const auto& s = solver->Solve(known.qp);
    ASSERT_EQ(s.status, QpStatus::kOptimal);
    EXPECT_LT((s.x - known.x).norm(), 1e-10);
  }
}

TEST(KktResidual, IsZeroAtTheSolutionTheProblemWasBuiltFromAndSeesAWrongSign) {
  for (const QpCase& c : kCases) {
    const KnownQp<9, 60> known = MakeQp<9, 60>(c, 7);
    QpSolution<9, 60> s;
    s.x = known.x;
    s.lambda_rows = known.lambda_rows;
    s.lambda_box = known.lambda_box;
    EXPECT_LT(KktResidual(known.qp, s), 1e-12) << c.name;
    s.lambda_rows[0] += 0.5;
    EXPECT_GT(KktResidual(known.qp, s), 0.05) << c.name;
  }
}

/// The least cost over every choice of active sides of a small hard problem; +inf when none fits.
template <int n, int m>
double BruteForce(const QpProblem<n, m>& qp, Vec<n>& best_x) {
  double best = kInfinity;
  int choices = 1;
  for (int i = 0; i < qp.rows; ++i) {
    choices *= 3;
  }
  for (int choice = 0; choice < choices; ++choice) {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + qp.rows, n + qp.rows);
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(n + qp.rows);
    K.topLeftCorner(n, n) = qp.H;
    rhs.head(n) = -qp.g;
    int active = n;
    bool possible = true;
    for (int i = 0, rest = choice; i < qp.rows; ++i, rest /= 3) {
      if (rest % 3 == 0) {
        continue;
      }
      const double limit = rest % 3 == 1 ? qp.lo[i] : qp.hi[i];
      possible = possible && std::isfinite(limit);
      K.block(active, 0, 1, n) = qp.A.row(i);
      K.block(0, active, n, 1) = qp.A.row(i).transpose();
      rhs[active++] = limit;
    }
    if (!possible || active > 2 * n) {
      continue;
    }
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(K.topLeftCorner(active, active));
    if (!lu.isInvertible()) {
      continue;
    }
    const Vec<n> x = lu.solve(rhs.head(active)).head(n);
    bool holds = true;
    for (int i = 0; i < qp.rows; ++i) {
      const double y = qp.A.row(i).dot(x);
      holds = holds && y <= qp.hi[i] + 1e-9 && y >= qp.lo[i] - 1e-9;
    }
    const double cost = x.dot(qp.H * x) / 2 + qp.g.dot(x);
    if (holds && cost < best) {
      best = cost;
      best_x = x;
    }
  }
  return best;
}

TEST(QpSolver, AgreesWithBruteForceOnFeasibilityAndAnswer) {
  QpSolver<3, 5> solver;
  int infeasible = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    QpProblem<3, 5> qp;
    qp.H = test::RandomHessian<3>(rng, 10);
    qp.g = test::RandomVec<3>(rng, 3);
    for (int i = 0; i < 5; ++i) {
      const double lo = rng.Uniform(-1, 1);
      const double width = rng.Uniform() < 0.2 ? 0 : rng.Uniform(0, 0.6);
      (void)qp.AddRow(test::RandomVec<3>(rng), rng.Uniform() < 0.3 ? -kInfinity : lo,
                      rng.Uniform() < 0.3 ? kInfinity : lo + width);
    }
    Vec<3> x = Vec<3>::Zero();
    const double best = BruteForce(qp, x);
    const QpSolution<3, 5>& s = solver.Solve(qp);
    if (best == kInfinity) {
      ++infeasible;
      EXPECT_EQ(s.status, QpStatus::kInfeasible);
    } else {
      ASSERT_EQ(s.status, QpStatus::kOptimal);
      EXPECT_LT((s.x - x).norm(), 1e-7);
    }
  }
  EXPECT_GT(infeasible, 20);
  EXPECT_LT(infeasible, 380);
}

TEST(QpSolver, SolvesSoftRowsAsTheProblemWithItsSlacksWrittenOut) {
  constexpr int kSoft = 6;
  const auto reduced = std::make_unique<QpSolver<6, 16>>();
  const auto full = std::make_unique<QpSolver<6 + kSoft, 16>>();
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    auto qp = std::make_unique<QpProblem<6, 16>>();
    auto big = std::make_unique<QpProblem<6 + kSoft, 16>>();
    qp->H = test::RandomHessian<6>(rng, 100);
    qp->g = test::RandomVec<6>(rng, 5);
    big->H.setIdentity();
    big->H.topLeftCorner<6, 6>() = qp->H;
    big->g.head<6>() = qp->g;
    for (int i = 0; i < 16; ++i) {
      const Vec<6> a = test::RandomVec<6>(rng);
      Vec<6 + kSoft> wide = Vec<6 + kSoft>::Zero();
      wide.head<6>() = a;
      const bool soft = i < kSoft;
      const double price = soft ? std::pow(10, rng.Uniform(-1, 4)) : 0;
      const double lo = soft ? rng.Uniform(-2, 2) : -rng.Uniform(0, 1);
      const double hi = soft ? lo + (i == 0 ? 0 : rng.Uniform(0, 1)) : rng.Uniform(0, 1);
      if (soft) {
        wide[6 + i] = -1;
        big->H(6 + i, 6 + i) = 2 * price;
      }
      (void)qp->AddRow(a, lo, hi, price);
      (void)big->AddRow(wide, lo, hi);
    }
    const auto& s = reduced->Solve(*qp);
    const auto& f = full->Solve(*big);
    ASSERT_EQ(s.status, QpStatus::kOptimal);
    ASSERT_EQ(f.status, QpStatus::kOptimal);
    EXPECT_LT(KktResidual(*qp, s), 1e-7);  // a row's 1e-11 times a multiplier of a dear one
    EXPECT_LT((s.x - f.x.head<6>()).norm(), 1e-8);
    EXPECT_LT((s.lambda_rows - f.lambda_rows).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace pipewright
