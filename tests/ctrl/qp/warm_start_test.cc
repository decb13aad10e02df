// SPDX-License-Identifier: MIT
// Starting from last time's active set changes the work, never the answer.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "ctrl/qp/dual_active_set_inl.h"
#include "tests/support/qp_problems.h"

namespace pipewright {
namespace {

constexpr int kN = 9;
constexpr int kM = 64;
using Problem = QpProblem<kN, kM>;
using Solver = QpSolver<kN, kM>;

/// A problem that drifts with the time t; its rows turn up in an order of their own, and some are
/// missing now and then, as a robot's constraints do.
Problem Drifting(double t, std::uint64_t order) {
  Rng fixed(42);
  Rng shuffle(order);
  Problem qp;
  qp.H = test::RandomHessian<kN>(fixed, 100);
  const Vec<kN> g0 = test::RandomVec<kN>(fixed, 10);
  const Vec<kN> g1 = test::RandomVec<kN>(fixed, 10);
  qp.g = g0 * std::cos(t) + g1 * std::sin(t);
  qp.lb.setConstant(-1);
  qp.ub.setConstant(1);
  struct Row {
    Vec<kN> a;
    double hi;
    double price;
    int key;
  };
  Row rows[kM];
  for (int i = 0; i < kM; ++i) {
    const Vec<kN> a0 = test::RandomVec<kN>(fixed);
    const Vec<kN> a1 = test::RandomVec<kN>(fixed);
    rows[i] = {a0 * std::cos(t / 2) + a1 * std::sin(t / 2), fixed.Uniform(0.2, 1),
               i % 4 == 0 ? 100.0 : 0.0, 1000 + 7 * i};
  }
  for (int i = kM - 1; i > 0; --i) {
    std::swap(rows[i], rows[shuffle.Index(i + 1)]);
  }
  for (const Row& row : rows) {
    if (shuffle.Uniform() < 0.95) {
      (void)qp.AddRow(row.a, -kInfinity, row.hi, row.price, row.key);
    }
  }
  return qp;
}

TEST(WarmStart, FindsTheSameAnswerInFewerIterationsThoughRowsMove) {
  const auto warm = std::make_unique<Solver>();
  const auto cold = std::make_unique<Solver>();
  int warm_iterations = 0;
  int cold_iterations = 0;
  for (int k = 0; k < 600; ++k) {
    SCOPED_TRACE(testing::Message() << "step " << k);
    const auto qp = std::make_unique<Problem>(Drifting(0.01 * k, static_cast<std::uint64_t>(k)));
    cold->ForgetActiveSet();
    const auto& w = warm->Solve(*qp);
    const auto& c = cold->Solve(*qp);
    ASSERT_EQ(w.status, QpStatus::kOptimal);
    ASSERT_EQ(c.status, QpStatus::kOptimal);
    EXPECT_LT((w.x - c.x).norm(), 1e-9);
    EXPECT_LT(KktResidual(*qp, w), 1e-9);
    warm_iterations += w.iterations;
    cold_iterations += c.iterations;
  }
  EXPECT_LT(warm_iterations * 3, cold_iterations);
}

TEST(WarmStart, FromAnUnrelatedProblemStillFindsTheAnswer) {
  const auto solver = std::make_unique<Solver>();
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    const test::QpCase c{.name = "",
                         .at_lower = rng.Index(3),
                         .at_upper = rng.Index(3),
                         .equalities = rng.Index(2),
                         .at_bound = rng.Index(3),
                         .soft = rng.Index(10)};
    const auto known = test::MakeQp<kN, kM>(c, seed);
    const auto& s = solver->Solve(known.qp);
    ASSERT_EQ(s.status, QpStatus::kOptimal);
    EXPECT_LT((s.x - known.x).norm(), 1e-9);
  }
}

TEST(WarmStart, TakesRepeatedKeysAndLimitsThatHaveGone) {
  const auto solver = std::make_unique<Solver>();
  auto qp = std::make_unique<Problem>(Drifting(1, 1));
  ASSERT_EQ(solver->Solve(*qp).status, QpStatus::kOptimal);
  for (int i = 0; i < qp->rows; ++i) {
    qp->key[i] = i % 3;
    qp->hi[i] = i % 2 == 0 ? kInfinity : qp->hi[i];
  }
  qp->ub.setConstant(kInfinity);
  const auto fresh = std::make_unique<Solver>();
  for (int again = 0; again < 3; ++again) {
    const auto& s = solver->Solve(*qp);
    ASSERT_EQ(s.status, QpStatus::kOptimal);
    EXPECT_LT((s.x - fresh->Solve(*qp).x).norm(), 1e-9);
  }
}

TEST(WarmStart, RepeatsItselfBitForBit) {
  const auto one = std::make_unique<Solver>();
  const auto two = std::make_unique<Solver>();
  for (int k = 0; k < 50; ++k) {
    const auto qp = std::make_unique<Problem>(Drifting(0.05 * k, 3));
    EXPECT_EQ(one->Solve(*qp).x, two->Solve(*qp).x);
  }
}

}  // namespace
}  // namespace pipewright
