// SPDX-License-Identifier: MIT
// Planes and pipes of unorganised points: what is found, and whether it is as far off as it says.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "perception/primitives/scatter_detector.h"
#include "perception/primitives/scatter_fit.h"
#include "perception/primitives/track.h"
#include "tests/support/chi_square.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// Points on true surfaces with even errors in every direction.
struct Scatter {
  double sigma_m = 0.01;
  Rng rng{17};
  Points points;

  void Add(const Vector3d& exact) {
    const Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    points.push_back((exact + sigma_m * error).cast<float>());
  }
  /// A rectangle about c with half sides along unit vectors.
  void AddPlane(const Vector3d& c, const Vector3d& e1, const Vector3d& e2, double a, double b,
                int count) {
    for (int k = 0; k < count; ++k) {
      Add(c + rng.Uniform(-a, a) * e1 + rng.Uniform(-b, b) * e2);
    }
  }
  /// The part of a cylinder of half length h between two angles about its axis.
  void AddPipe(const Vector3d& c, const Vector3d& l, double r, double h, double arc_rad,
               int count) {
    const Vector3d e1 = l.unitOrthogonal();
    const Vector3d e2 = l.cross(e1);
    for (int k = 0; k < count; ++k) {
      const double a = rng.Uniform(-arc_rad / 2, arc_rad / 2);
      Add(c + rng.Uniform(-h, h) * l + r * (std::cos(a) * e1 + std::sin(a) * e2));
    }
  }
};

template <int n>
double Nees(const Vec<n>& error, const Mat<n, n>& covariance) {
  return error.dot(Eigen::LDLT<Mat<n, n>>(covariance).solve(error));
}

TEST(FitScatteredPlane, StatesItsErrorTruly) {
  Scatter scatter;
  std::vector<double> nees;
  for (int k = 0; k < 2000; ++k) {
    scatter.points.clear();
    scatter.sigma_m = scatter.rng.Uniform(0.002, 0.03);
    const Vector3d n = Vector3d(0.3, -0.4, 1).normalized();
    const Vector3d e1 = n.unitOrthogonal();
    const Vector3d e2 = n.cross(e1);
    const Vector3d c(0.3, 0.2, -2);
    scatter.AddPlane(c, e1, e2, 0.6, 0.3, 300);
    const auto fit = FitScatteredPlane(scatter.points, 0.01);
    ASSERT_TRUE(fit.ok());
    Mat<3, 4> H = Mat<3, 4>::Zero();
    H.block<1, 3>(0, 0) = e1.transpose();
    H.block<1, 3>(1, 0) = e2.transpose();
    H.block<1, 3>(2, 0) = -c.transpose();
    H(2, 3) = 1;
    Vec<4> error;
    error << fit->n_S - n, fit->d_m - n.dot(c);
    nees.push_back(Nees<3>(H * error, H * fit->covariance * H.transpose()));
  }
  // The spread comes from 297 residuals, which makes the squares F- rather than chi-square
  // distributed: 1 % at most, a third of the band on the mean.
  const test::Calibration c = test::Calibrate(nees, 3);
  EXPECT_TRUE(c.within()) << c.mean.value << " " << c.p50.value << " " << c.p90.value << " "
                          << c.p99.value;
}

TEST(FitScatteredCylinder, StatesItsErrorTruly) {
  Scatter scatter;
  std::vector<double> nees;
  for (int k = 0; k < 1000; ++k) {
    scatter.points.clear();
    scatter.sigma_m = scatter.rng.Uniform(0.001, 0.006);
    const double r = scatter.rng.Uniform(0.05, 0.2);
    const Vector3d l = Vector3d(1, 0.3, 0.2).normalized();
    const Vector3d c(0.1, 0.05, 0.8);
    scatter.AddPipe(c, l, r, 0.4, 3.0, 600);
    CylinderFit start;
    start.p_S = c + Vector3d(0.01, -0.01, 0.01);
    start.l_S = (l + Vector3d(0.03, 0.05, -0.05)).normalized();
    start.radius_m = 1.1 * r;
    const auto fit = FitScatteredCylinder(scatter.points, start, scatter.sigma_m);
    ASSERT_TRUE(fit.ok());
    const Vector3d at = c + fit->l_S.dot(fit->p_S - c) / fit->l_S.dot(l) * l;
    Vec<7> error;
    error << fit->p_S - at, fit->l_S - l, fit->radius_m - r;
    PipeEstimate pipe;
    pipe.l_W = fit->l_S;
    const Mat<7, 5> G = PipeTangent(pipe);
    nees.push_back(Nees<5>(G.transpose() * error, G.transpose() * fit->covariance * G));
  }
  const test::Calibration c = test::Calibrate(nees, 5);
  EXPECT_TRUE(c.within()) << c.mean.value << " " << c.p50.value << " " << c.p90.value << " "
                          << c.p99.value;
}

TEST(FitScattered, RefusesWhatLeavesSomethingFree) {
  Points line;
  for (int k = 0; k < 50; ++k) {
    line.emplace_back(0.01F * static_cast<float>(k), 0.0F, 1.0F);
  }
  EXPECT_EQ(FitScatteredPlane(line, 0.01).status(), Status::kInfeasible);
  EXPECT_EQ(FitScatteredPlane(Points(3), 0.01).status(), Status::kInfeasible);
  CylinderFit start;
  start.p_S = {0, 0, 1.05};
  start.radius_m = 0.05;
  EXPECT_FALSE(FitScatteredCylinder(line, start, 0.01).ok());
  EXPECT_FALSE(FitScatteredCylinder(Points(5), start, 0.01).ok());
}

/// Two walls, a floor and two pipes about the origin.
Scatter Corner() {
  Scatter scatter;
  const Vector3d x = Vector3d::UnitX();
  const Vector3d y = Vector3d::UnitY();
  const Vector3d z = Vector3d::UnitZ();
  scatter.AddPlane({3, 0, 0}, y, z, 2, 1, 4000);
  scatter.AddPlane({0, -2, 0}, x, z, 3, 1, 4000);
  scatter.AddPlane({0, 0, -1}, x, y, 3, 2, 4000);
  scatter.AddPipe({1.5, 0.5, 0}, z, 0.12, 0.9, 2 * std::numbers::pi, 1500);
  scatter.AddPipe({-1, 0, 0.2}, (x + 0.3 * z).normalized(), 0.08, 0.7, 3.0, 1000);
  std::shuffle(scatter.points.begin(), scatter.points.end(), std::minstd_rand(3));
  return scatter;
}

TEST(ScatterDetector, FindsWallsAndPipesOfACornerInAnyOrderAndNothingElse) {
  Scatter scatter = Corner();
  scatter.points.insert(scatter.points.begin(), 100, Eigen::Vector3f(NAN, NAN, NAN));  // no reading
  const auto detector = std::make_unique<ScatterDetector>(ScatterConfig{}, 1);
  {
    const test::NoAllocScope no_heap;
    detector->Detect(scatter.points);
  }
  EXPECT_EQ(detector->points_used(), 14500);
  ASSERT_EQ(detector->planes().size(), 3);
  for (const DetectedPlane& plane : detector->planes()) {
    int axis = 0;
    const double most = plane.fit.n_S.cwiseAbs().maxCoeff(&axis);
    EXPECT_GT(most, 0.9999);
    EXPECT_NEAR(plane.fit.d_m, axis == 0 ? -3 : axis == 1 ? -2 : -1, 0.005);
    EXPECT_NEAR(plane.fit.chi2, 1, 0.15);
    EXPECT_GT(plane.hi_m[0] - plane.lo_m[0], 3.5);
  }
  ASSERT_EQ(detector->pipes().size(), 2);
  for (const DetectedPipe& pipe : detector->pipes()) {
    const bool upright = std::abs(pipe.fit.l_S.z()) > 0.9;
    const Vector3d l = upright ? Vector3d(0, 0, 1) : Vector3d(1, 0, 0.3).normalized();
    EXPECT_GT(std::abs(pipe.fit.l_S.dot(l)), 0.9995);
    EXPECT_NEAR(pipe.fit.radius_m, upright ? 0.12 : 0.08, 0.004);
    EXPECT_NEAR(pipe.hi_m - pipe.lo_m, upright ? 1.8 : 1.4, 0.2);
  }
}

TEST(ScatterDetector, FindsNothingInNothingNorInACloudWithoutSurfaces) {
  const auto detector = std::make_unique<ScatterDetector>(ScatterConfig{}, 1);
  detector->Detect({});
  EXPECT_EQ(detector->points_used(), 0);
  Scatter scatter;
  scatter.sigma_m = 0.4;
  for (int k = 0; k < 5000; ++k) {
    scatter.Add({2, 0, 0});
  }
  detector->Detect(scatter.points);
  EXPECT_EQ(detector->planes().size(), 0);
  EXPECT_EQ(detector->pipes().size(), 0);
}

TEST(ScatterDetector, ThinsWhatItHasNoRoomForAndGivesTheSameForTheSame) {
  Scatter scatter;
  scatter.AddPlane({0, 0, -1}, Vector3d::UnitX(), Vector3d::UnitY(), 2, 2, 3 << 15);
  const auto one = std::make_unique<ScatterDetector>(ScatterConfig{}, 5);
  const auto two = std::make_unique<ScatterDetector>(ScatterConfig{}, 5);
  one->Detect(scatter.points);
  two->Detect(scatter.points);
  EXPECT_LE(one->points_used(), 1 << 15);
  EXPECT_GE(one->points_used(), 1 << 14);
  ASSERT_EQ(one->planes().size(), 1);
  EXPECT_EQ(one->planes()[0].fit.covariance, two->planes()[0].fit.covariance);
}

}  // namespace
}  // namespace pipewright
