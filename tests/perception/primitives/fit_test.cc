// SPDX-License-Identifier: MIT
#include "perception/primitives/fit.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// Readings of a plane or cylinder on a grid of rays, depth with noise c z² and no rounding.
struct Sampler {
  DepthNoise noise{.c_1pm = 0.0038, .step_m = 0};
  Rng rng{5};

  void Add(Points& points, const Vector3d& ray, double z) {
    const double noisy = z + noise.c_1pm * z * z * rng.Normal();
    points.push_back((noisy * ray).cast<float>());
  }

  Points Plane(const Vector3d& n, double d) {
    Points points;
    for (double y = -0.4; y <= 0.4; y += 0.02) {
      for (double x = -0.6; x <= 0.6; x += 0.02) {
        const Vector3d ray(x, y, 1);
        Add(points, ray, d / n.dot(ray));
      }
    }
    return points;
  }

  Points Cylinder(const Vector3d& p, const Vector3d& l, double r) {
    Points points;
    for (double y = -0.5; y <= 0.5; y += 0.01) {
      for (double x = -0.7; x <= 0.7; x += 0.01) {
        const Vector3d ray(x, y, 1);
        const Vector3d a = ray - l.dot(ray) * l;
        const Vector3d c = p - l.dot(p) * l;
        const double root = a.dot(c) * a.dot(c) - a.dot(a) * (c.dot(c) - r * r);
        if (root > 0) {
          const double z = (a.dot(c) - std::sqrt(root)) / a.dot(a);
          // Readings that graze the surface are those a camera does not give.
          const Vector3d g = (z * a - c) / r;
          if (std::abs(g.dot(ray)) > 0.3 * ray.norm()) {
            Add(points, ray, z);
          }
        }
      }
    }
    return points;
  }
};

/// Error squared over the stated covariance, on the directions that the covariance spans.
template <int n>
double Nees(const Vec<n>& error, const Mat<n, n>& covariance, int rank) {
  const Eigen::SelfAdjointEigenSolver<Mat<n, n>> eigen(covariance);
  double sum = 0;
  for (int i = n - rank; i < n; ++i) {
    const double along = eigen.eigenvectors().col(i).dot(error);
    sum += along * along / eigen.eigenvalues()(i);
  }
  return sum;
}

TEST(FitPlane, StatesItsErrorTruly) {
  Sampler sampler;
  const Vector3d n = Vector3d(0.3, -0.2, -1).normalized();
  double sum = 0;
  constexpr int kDraws = 1000;
  for (int k = 0; k < kDraws; ++k) {
    const Points points = sampler.Plane(n, -1.2);
    const auto fit = FitPlane(points, sampler.noise);
    ASSERT_TRUE(fit.ok());
    Vec<4> error;
    error << fit->n_S - n, fit->d_m + 1.2;
    sum += Nees<4>(error, fit->covariance, 3);
  }
  // Mean of chi-square with 3 degrees of freedom over 1000 draws: 3 ± 0.077; 3 sigma and the
  // inflation by chance where chi2 > 1.
  EXPECT_NEAR(sum / kDraws, 3, 0.3);
}

TEST(FitPlane, CovarianceHasRankThreeAndTheNormalsPartIsAcrossTheNormal) {
  Sampler sampler;
  const auto fit = FitPlane(sampler.Plane(-Vector3d::UnitZ(), -1), sampler.noise);
  ASSERT_TRUE(fit.ok());
  const Eigen::SelfAdjointEigenSolver<Mat<4, 4>> eigen(fit->covariance);
  EXPECT_NEAR(eigen.eigenvalues()(0), 0, 1e-15);
  EXPECT_GT(eigen.eigenvalues()(1), 1e-12);
  EXPECT_NEAR((fit->covariance.topLeftCorner<3, 3>() * fit->n_S).norm(), 0, 1e-15);
}

TEST(FitPlane, RefusesPointsOnALine) {
  Points points;
  for (int k = 0; k < 50; ++k) {
    points.emplace_back(0.01F * static_cast<float>(k), 0.0F, 1.0F);
  }
  EXPECT_EQ(FitPlane(points, {}).status(), Status::kInfeasible);
  EXPECT_EQ(FitPlane(Points(3), {}).status(), Status::kInfeasible);
}

TEST(FitPlane, WidensItsCovarianceWhereTheNoiseIsWorseThanStated) {
  Sampler sampler;
  const Points points = sampler.Plane(-Vector3d::UnitZ(), -1);
  DepthNoise optimist = sampler.noise;
  optimist.c_1pm /= 3;
  const auto fit = FitPlane(points, sampler.noise);
  const auto wide = FitPlane(points, optimist);
  ASSERT_TRUE(fit.ok() && wide.ok());
  EXPECT_NEAR(wide->chi2, 9, 1);
  EXPECT_NEAR(wide->covariance(3, 3) / fit->covariance(3, 3), 1, 0.15);
}

TEST(FitCylinder, StatesItsErrorTruly) {
  Sampler sampler;
  const Vector3d l = Vector3d(1, 0.3, 0.2).normalized();
  const Vector3d p(0.1, 0.05, 0.8);
  CylinderFit start;
  start.p_S = p + Vector3d(0.01, -0.01, 0.01);
  start.l_S = (l + Vector3d(0.03, 0.05, -0.05)).normalized();
  start.radius_m = 0.06;
  double sum = 0;
  constexpr int kDraws = 500;
  for (int k = 0; k < kDraws; ++k) {
    const auto fit = FitCylinder(sampler.Cylinder(p, l, 0.05), start, sampler.noise);
    ASSERT_TRUE(fit.ok());
    const Vector3d at = p + fit->l_S.dot(fit->p_S - p) / fit->l_S.dot(l) * l;  // beside p_S
    Vec<7> error;
    error << fit->p_S - at, fit->l_S - l, fit->radius_m - 0.05;
    sum += Nees<7>(error, fit->covariance, 5);
  }
  EXPECT_NEAR(sum / kDraws, 5, 0.5);
}

TEST(FitCylinder, RefusesPointsOfAPlaneAndTooFew) {
  Sampler sampler;
  CylinderFit start;
  start.p_S = {0, 0, 1.05};
  start.radius_m = 0.05;
  EXPECT_FALSE(FitCylinder(sampler.Plane(-Vector3d::UnitZ(), -1), start, sampler.noise).ok());
  EXPECT_EQ(FitCylinder(Points(5), start, sampler.noise).status(), Status::kInfeasible);
}

}  // namespace
}  // namespace pipewright
