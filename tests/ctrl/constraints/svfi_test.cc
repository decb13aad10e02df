// SPDX-License-Identifier: MIT
#include "ctrl/constraints/svfi.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::MakePipe;
using test::MakePlane;
using test::RandomDirection;
using test::RandomIn;

const Vector3d kLo{-1, -1, -1};
const Vector3d kHi{1, 1, 1};

PlaneEstimate RandomPlane(Rng& rng) {
  PlaneEstimate plane = MakePlane(1, RandomIn(rng, kLo, kHi), RandomDirection(rng), 1, 0, 0);
  plane.covariance = test::RandomCovariance<4>(rng, 0.02);
  return plane;
}

TEST(ChanceQuantile, RefusesWhereTheConstraintIsNotConvex) {
  for (const double alpha : {0.49999, 0.0, -1.0, 1.0, 1.5, std::nan("")}) {
    EXPECT_EQ(ChanceQuantile(alpha).status(), Status::kOutOfRange) << alpha;
  }
  EXPECT_EQ(*ChanceQuantile(0.5), 0);
  EXPECT_NEAR(*ChanceQuantile(0.7), 0.5244005127080407, 1e-14);   // tables of Phi^-1
  EXPECT_NEAR(*ChanceQuantile(0.99), 2.3263478740408408, 1e-13);  //
}

TEST(PlaneCone, IsTheDeviationOfAFunctionLinearInThePlane) {
  for (int i = 0; i < 200; ++i) {
    Rng rng(1, i);
    const PlaneEstimate plane = RandomPlane(rng);
    const Vector3d t = RandomIn(rng, kLo, kHi);
    const Vector3d v = RandomIn(rng, kLo, kHi);
    const double eta = rng.Uniform(0.1, 5);
    Vec<4> gradient;  // (14)
    gradient << v + eta * t, -eta;
    const double sigma = std::sqrt(gradient.dot(plane.covariance * gradient));
    EXPECT_NEAR(PlaneCone(plane, t, eta).Sigma(v), sigma, 1e-12);
  }
}

TEST(PlaneCone, DoesNotDependOnTheOrigin) {
  for (int i = 0; i < 200; ++i) {
    Rng rng(2, i);
    const PlaneEstimate plane = RandomPlane(rng);
    const Vector3d t = RandomIn(rng, kLo, kHi);
    const Vector3d v = RandomIn(rng, kLo, kHi);
    const Vector3d o = RandomIn(rng, 5 * kLo, 5 * kHi);
    PlaneEstimate moved = plane;  // seen from O: n stays, d becomes d − n'o
    moved.d_m -= plane.n_W.dot(o);
    Mat<4, 4> T = Mat<4, 4>::Identity();
    T.block<1, 3>(3, 0) = -o.transpose();
    moved.covariance = T * plane.covariance * T.transpose();
    EXPECT_NEAR(PointToPlane(t - o, moved).d_m, PointToPlane(t, plane).d_m, 1e-12);
    EXPECT_NEAR(PlaneCone(moved, t - o, 1.5).Sigma(v), PlaneCone(plane, t, 1.5).Sigma(v), 1e-10);
  }
}

/// f = ∇d(θ)'v + η d(θ) for θ = (p, l, r), without any of the code under test.
double PipeFunction(const Vec<7>& theta, const Vector3d& t, const Vector3d& v, double eta,
                    bool at_end, double s) {
  const Vector3d p = theta.head<3>();
  const Vector3d l = theta.segment<3>(3).normalized();
  const Vector3d foot = p + (at_end ? s : l.dot(t - p)) * l;
  const double rho = (t - foot).norm();
  return (t - foot).dot(v) / rho + eta * (rho - theta(6));
}

TEST(PipeCone, IsTheFirstOrderDeviation) {
  for (int i = 0; i < 400; ++i) {
    SCOPED_TRACE(i);
    Rng rng(3, i);
    PipeEstimate pipe = MakePipe(1, RandomIn(rng, kLo, kHi), RandomDirection(rng), 0.05, 5,
                                 rng.Uniform(0, 0.02), rng.Uniform(0, 0.1));
    if (i % 2 == 1) {
      pipe.extent_lo_m = pipe.extent_hi_m = 2.5;
    }
    // p, l and r together; p moves across the axis, l across itself.
    Mat<7, 7> across = Mat<7, 7>::Identity();
    across.block<3, 3>(0, 0) -= pipe.l_W * pipe.l_W.transpose();
    across.block<3, 3>(3, 3) -= pipe.l_W * pipe.l_W.transpose();
    pipe.covariance += across * test::RandomCovariance<7>(rng, 0.02) * across;
    const Vector3d t = RandomIn(rng, kLo, kHi);
    const Vector3d v = RandomIn(rng, kLo, kHi);
    const double eta = rng.Uniform(0.1, 5);
    const AxisDistance distance = PointToPipeAxis(t, pipe, 0);
    if (distance.to_axis.d_m < 0.05) {
      continue;
    }
    Vec<7> theta;
    theta << pipe.p_W, pipe.l_W, pipe.radius_m;
    Vec<7> gradient;
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 7; ++k) {
      Vec<7> hi = theta;
      Vec<7> lo = theta;
      hi(k) += kStep;
      lo(k) -= kStep;
      gradient(k) = (PipeFunction(hi, t, v, eta, distance.at_end, distance.s_m) -
                     PipeFunction(lo, t, v, eta, distance.at_end, distance.s_m)) /
                    (2 * kStep);
    }
    const double sigma = std::sqrt(gradient.dot(pipe.covariance * gradient));
    EXPECT_NEAR(PipeCone(pipe, distance, eta).Sigma(v), sigma, 1e-7);
  }
}

/// f = ∇d'v + η d for a box along W's axes.
double BoxFunction(const Vector3d& lo, const Vector3d& hi, const Vector3d& t, const Vector3d& v,
                   double eta) {
  const Vector3d off = t - t.cwiseMax(lo).cwiseMin(hi);
  return off.dot(v) / off.norm() + eta * off.norm();
}

TEST(VoxelCone, IsTheFirstOrderDeviationOfAMovedBox) {
  int features[4] = {};  // by how many of the direction's components are not zero
  for (int i = 0; i < 400; ++i) {
    SCOPED_TRACE(i);
    Rng rng(8, i);
    const Vector3d lo = RandomIn(rng, kLo, kHi);
    const Vector3d hi = lo + Vector3d::Constant(rng.Uniform(0.05, 0.4));
    const Vector3d t = lo + RandomIn(rng, 0.6 * kLo, 0.8 * kHi);
    const Vector3d v = RandomIn(rng, kLo, kHi);
    const double eta = rng.Uniform(0.1, 5);
    const double sigma = rng.Uniform(0, 0.02);
    const PointDistance distance = PointToPoint(t, t.cwiseMax(lo).cwiseMin(hi));
    if (distance.d_m < 0.02) {
      continue;
    }
    ++features[(distance.gradient_W.array() != 0).count()];
    double variance = 0;
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vector3d step = kStep * Vector3d::Unit(k);
      const double slope = (BoxFunction(lo + step, hi + step, t, v, eta) -
                            BoxFunction(lo - step, hi - step, t, v, eta)) /
                           (2 * kStep);
      variance += slope * slope * sigma * sigma;
    }
    const VelocityCone cone = VoxelCone(BoxCurvature(distance), sigma, eta);
    EXPECT_NEAR(cone.Sigma(v), std::sqrt(variance), 1e-8);
  }
  EXPECT_GT(features[1], 20);  // faces, edges and corners
  EXPECT_GT(features[2], 20);
  EXPECT_GT(features[3], 20);
}

ChanceRow RandomRow(Rng& rng) {
  ChanceRow row;
  for (int i = 0; i < kControls; ++i) {
    row.J.col(i) = RandomIn(rng, kLo, kHi);
  }
  const PlaneEstimate plane = RandomPlane(rng);
  row.a = -(row.J.transpose() * plane.n_W);
  row.cone = PlaneCone(plane, RandomIn(rng, kLo, kHi), 1);
  row.b = row.limit = 0.1;
  return row;
}

Controls RandomControls(Rng& rng) {
  Controls u;
  for (int i = 0; i < kControls; ++i) {
    u(i) = rng.Uniform(-1, 1);
  }
  return u;
}

TEST(TangentCut, NeverCutsOffWhatTheConeAllowsAndIsExactAtItsPoint) {
  for (int i = 0; i < 500; ++i) {
    Rng rng(4, i);
    const ChanceRow row = RandomRow(rng);
    const double z = rng.Uniform(0, 3);
    const Controls u0 = RandomControls(rng);
    const Controls u = RandomControls(rng);
    const Row cut = TangentCut(row, u0, z);
    EXPECT_LE(cut.a.dot(u) - cut.hi, ChanceExcess(row, u, z) + 1e-12);
    EXPECT_NEAR(cut.a.dot(u0) - cut.hi, ChanceExcess(row, u0, z), 1e-12);
  }
}

TEST(VelocityCone, DerivativesAreThoseOfFiniteDifferences) {
  for (int i = 0; i < 200; ++i) {
    Rng rng(7, i);
    const VelocityCone cone = RandomRow(rng).cone;
    const Vector3d v = RandomIn(rng, kLo, kHi);
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 3; ++k) {
      const Vector3d step = kStep * Vector3d::Unit(k);
      EXPECT_NEAR(cone.Gradient(v)(k), (cone.Sigma(v + step) - cone.Sigma(v - step)) / (2 * kStep),
                  1e-8);
      EXPECT_LT((cone.Curvature(v).col(k) -
                 (cone.Gradient(v + step) - cone.Gradient(v - step)) / (2 * kStep))
                    .norm(),
                1e-6);
    }
  }
}

TEST(WorstCaseRow, NeverUnderestimatesWithinTheBox) {
  for (int i = 0; i < 500; ++i) {
    Rng rng(5, i);
    ChanceRow row = RandomRow(rng);
    row.price = 1;  // a hard row's right side is clamped
    const double z = rng.Uniform(0, 3);
    const Controls lb = -RandomControls(rng).cwiseAbs();
    const Controls ub = RandomControls(rng).cwiseAbs();
    const Row worst = WorstCaseRow(row, lb, ub, z);
    const Controls u = lb + (ub - lb).cwiseProduct(RandomControls(rng).cwiseAbs());
    EXPECT_GE(worst.a.dot(u) - worst.hi, ChanceExcess(row, u, z) - 1e-12);
  }
}

TEST(VelocityCone, WithoutCovarianceIsTheDeterministicRow) {
  Rng rng(6);
  ChanceRow row = RandomRow(rng);
  row.cone = VelocityCone{};
  const Controls u = RandomControls(rng);
  EXPECT_EQ(ChanceExcess(row, u, 2), row.a.dot(u) - row.limit);
  const Row cut = TangentCut(row, u, 2);
  EXPECT_EQ(cut.a, row.a);
  EXPECT_EQ(cut.hi, row.limit);
}

}  // namespace
}  // namespace pipewright
