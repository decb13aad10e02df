// SPDX-License-Identifier: MIT
#include "perception/localization/placement.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

/// Of a state of four, by A A'.
Mat<4, 4> AnyCovariance(Rng& rng) {
  Mat<4, 4> A;
  for (double& a : A.reshaped()) {
    a = rng.Normal();
  }
  return A * A.transpose();
}

TEST(CommonWith, MovesVarianceAndLosesNone) {
  Rng rng(7);
  for (int k = 0; k < 1000; ++k) {
    const Mat<4, 4> before = AnyCovariance(rng);
    const Vector3d had = 3 * Vector3d(rng.Uniform(), rng.Uniform(), rng.Uniform());
    const Placement surfaces{.m2 = 5 * rng.Uniform(), .rad2 = 5 * rng.Uniform()};
    Mat<4, 4> P = before;
    const Vector3d common = CommonWith(surfaces, had, P);

    const Vector3d total = before.diagonal().head<3>() + had;
    EXPECT_LT((P.diagonal().head<3>() + common - total).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_EQ(P(3, 3), before(3, 3));
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(common(i), std::min(total(i), i < 2 ? surfaces.m2 : surfaces.rad2));
    }
    EXPECT_EQ(P, P.transpose());
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double pull = std::abs(before(i, j) / before(j, j));
        EXPECT_LE(std::abs(P(i, j)), pull * P(j, j) * (1 + 1e-9) + 1e-12) << "of j on i";
      }
    }
    const Eigen::SelfAdjointEigenSolver<Mat<4, 4>> solver(P, Eigen::EigenvaluesOnly);
    EXPECT_GT(solver.eigenvalues()(0), -1e-12);
  }
}

TEST(CommonWith, NothingIsCommonWithWhatIsPlacedExactly) {
  Rng rng(8);
  const Mat<4, 4> before = AnyCovariance(rng);
  Mat<4, 4> P = before;
  EXPECT_EQ(CommonWith({}, Vector3d::Zero(), P), Vector3d::Zero());
  EXPECT_EQ(P, before);
}

TEST(TakeOut, LeavesNothingWhereThereIsLess) {
  Rng rng(9);
  for (int k = 0; k < 1000; ++k) {
    Mat<4, 4> P = AnyCovariance(rng);
    if (k % 2 == 0) {
      P.row(1).setZero();
      P.col(1).setZero();
    }
    const Mat<4, 4> before = P;
    const Vector3d more(before(0, 0) / 2, before(1, 1) + rng.Uniform(), -rng.Uniform());
    TakeOut(more, P);
    EXPECT_NEAR(P(0, 0), before(0, 0) / 2, 1e-12);
    EXPECT_TRUE(P.row(1).isZero() && P.col(1).isZero());
    EXPECT_NEAR(P(2, 2), before(2, 2) - more(2), 1e-12);
    const Eigen::SelfAdjointEigenSolver<Mat<4, 4>> solver(P, Eigen::EigenvaluesOnly);
    EXPECT_GT(solver.eigenvalues()(0), -1e-12);
  }
}

TEST(CommonWith, APoseThatIsKnownExactlyStaysSo) {
  Mat<3, 3> P = Mat<3, 3>::Zero();
  EXPECT_EQ(CommonWith({.m2 = 1, .rad2 = 1}, Vector3d::Zero(), P), Vector3d::Zero());
  EXPECT_EQ(P, (Mat<3, 3>::Zero()));
}

}  // namespace
}  // namespace pipewright
