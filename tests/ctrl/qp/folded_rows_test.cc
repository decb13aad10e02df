// SPDX-License-Identifier: MIT
// Soft rows that a warm start folds into the cost: they leave, come back and give way to others,
// and the answer is that of the problem with every slack written out.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "ctrl/qp/dual_active_set_inl.h"
#include "tests/support/qp_problems.h"

namespace pipewright {
namespace {

constexpr int kN = 7;
constexpr int kSoft = 20;
constexpr int kHard = 12;
constexpr int kM = kSoft + kHard;

/// Soft rows with two sides and some hard ones that u = 0 keeps, the first kSoft of them soft.
/// `shift` moves the soft rows' limits: as it grows, rows that were leaned on are far from it.
QpProblem<kN, kM> Shifting(std::uint64_t seed, double shift, double price_exponent) {
  Rng rng(seed);
  QpProblem<kN, kM> qp;
  qp.H = test::RandomHessian<kN>(rng, 50);
  qp.g = test::RandomVec<kN>(rng, 5);
  qp.lb.setConstant(-2);
  qp.ub.setConstant(2);
  for (int i = 0; i < kM; ++i) {
    const Vec<kN> a = test::RandomVec<kN>(rng);
    const bool soft = i < kSoft;
    const double middle = soft ? rng.Uniform(-2, 2) + shift * rng.Uniform(-1, 1) : 0;
    const double half = rng.Uniform(0.05, 1);
    const double price = soft ? std::pow(10, rng.Uniform(0, price_exponent)) : 0;
    (void)qp.AddRow(a, middle - half, middle + half, price);
  }
  return qp;
}

/// The same with one variable more a soft row, and no soft row.
QpProblem<kN + kSoft, kM> WithSlacks(const QpProblem<kN, kM>& qp) {
  QpProblem<kN + kSoft, kM> big;
  big.H.setIdentity();
  big.H.topLeftCorner<kN, kN>() = qp.H;
  big.g.head<kN>() = qp.g;
  big.lb.head<kN>() = qp.lb;
  big.ub.head<kN>() = qp.ub;
  for (int i = 0; i < kM; ++i) {
    Vec<kN + kSoft> a = Vec<kN + kSoft>::Zero();
    a.head<kN>() = qp.A.row(i).transpose();
    if (i < kSoft) {
      a[kN + i] = -1;
      big.H(kN + i, kN + i) = 2 * qp.price[i];
    }
    (void)big.AddRow(a, qp.lo[i], qp.hi[i]);
  }
  return big;
}

/// Solves `steps` problems in a row, each `step` further than the last, on one warm solver.
void FollowAndCompare(std::uint64_t seed, double step, int steps, double price_exponent) {
  const auto warm = std::make_unique<QpSolver<kN, kM>>();
  const auto full = std::make_unique<QpSolver<kN + kSoft, kM>>();
  const double tolerance = 1e-10 * std::pow(10, price_exponent);  // of a multiplier: price times x
  for (int k = 0; k < steps; ++k) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << " step " << k);
    const auto qp =
        std::make_unique<QpProblem<kN, kM>>(Shifting(seed, std::sin(step * k), price_exponent));
    const auto big = std::make_unique<QpProblem<kN + kSoft, kM>>(WithSlacks(*qp));
    full->ForgetActiveSet();
    const auto& w = warm->Solve(*qp);
    const auto& f = full->Solve(*big);
    ASSERT_EQ(w.status, QpStatus::kOptimal);
    ASSERT_EQ(f.status, QpStatus::kOptimal);
    EXPECT_LT((w.x - f.x.head<kN>()).norm(), 1e-8);
    EXPECT_LT((w.lambda_rows - f.lambda_rows).norm(), 1e-8 + tolerance);
    EXPECT_LT(KktResidual(*qp, w), 1e-8 + tolerance);
  }
}

TEST(FoldedRows, DriftingSlowlyGiveTheAnswerOfTheProblemWithSlacks) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    FollowAndCompare(seed, 0.02, 40, 4);
  }
}

TEST(FoldedRows, LeaveAndComeBackWhenTheProblemJumps) {
  for (std::uint64_t seed = 100; seed < 140; ++seed) {
    FollowAndCompare(seed, 1.3, 12, 4);
  }
}

TEST(FoldedRows, TooDearToFoldAreMembersAsBefore) {
  for (std::uint64_t seed = 200; seed < 220; ++seed) {
    FollowAndCompare(seed, 0.3, 12, 7);
  }
}

TEST(FoldedRows, MayContradictOneAnother) {
  // Two soft rows that pull one variable apart, and a warm start that has folded both: the answer
  // is the balance of their prices, by hand.
  QpSolver<1, 8> solver;
  for (const double lo : {1.0, 0.5, -3.0, 1.0}) {
    QpProblem<1, 8> qp;  // 1/2 x^2 + 50 (x - lo)^2 + 200 (x + 1)^2 while the rows are leaned on
    Vec<1> a;
    a << 1;
    ASSERT_TRUE(qp.AddRow(a, lo, kInfinity, 50));
    ASSERT_TRUE(qp.AddRow(a, -kInfinity, -1, 200));
    const auto& s = solver.Solve(qp);
    ASSERT_EQ(s.status, QpStatus::kOptimal);
    const double both = (100 * lo - 400) / 501;
    const double second_only = -400.0 / 401;
    EXPECT_NEAR(s.x[0], lo > second_only ? both : second_only, 1e-12);
  }
}

TEST(FoldedRows, MakeRoomWhenMoreRowsAreLeanedOnThanTheWorkingSetHolds) {
  constexpr int kRows = 192;
  using Solver = QpSolver<9, kRows>;
  const auto solver = std::make_unique<Solver>(QpConfig{.max_iterations = 1000});
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Rng rng(seed);
    const auto qp = std::make_unique<QpProblem<9, kRows>>();
    qp->H = test::RandomHessian<9>(rng, 10);
    for (int i = 0; i < kRows; ++i) {  // no u comes near any
      const Vec<9> a = test::RandomVec<9>(rng);
      ASSERT_TRUE(qp->AddRow(a, rng.Uniform(8, 9), kInfinity, rng.Uniform(0.1, 10)));
    }
    solver->ForgetActiveSet();
    const auto& s = solver->Solve(*qp);
    ASSERT_EQ(s.status, QpStatus::kOptimal);
    int leaned_on = 0;
    for (int i = 0; i < kRows; ++i) {
      leaned_on += s.lambda_rows[i] < 0;
    }
    EXPECT_GT(leaned_on, 100);
    EXPECT_LT(KktResidual(*qp, s), 1e-7);
  }
}

}  // namespace
}  // namespace pipewright
