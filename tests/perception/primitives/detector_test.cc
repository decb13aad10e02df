// SPDX-License-Identifier: MIT
#include "perception/primitives/detector.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <memory>

#include "seen_world.h"

namespace pipewright {
namespace {

using test::Cell;
using test::Lens;
using test::LookingAt;
using test::See;
using test::TruePipe;
using test::TruePlane;
using test::World;

/// A camera, the detector behind it, and its last frame.
struct Bench {
  PrimitiveConfig config;
  Lens lens;
  Rng rng{11};
  std::unique_ptr<Cloud> cloud = std::make_unique<Cloud>();
  std::unique_ptr<DepthView> view = std::make_unique<DepthView>();
  std::unique_ptr<PrimitiveDetector> detector = std::make_unique<PrimitiveDetector>(config, 7);

  void Look(const World& world, const Vector3d& eye, const Vector3d& target) {
    See(world, LookingAt(eye, target), lens, config.noise, rng, *cloud);
    ASSERT_EQ(view->Set(*cloud, config.noise), Status::kOk);
    detector->Detect(*view, {});
  }
  Vector3d Eye() { return {rng.Uniform(0.2, 0.8), rng.Uniform(0.4, 1.1), rng.Uniform(0.5, 1.2)}; }
  Vector3d Target() {
    return {rng.Uniform(0.9, 1.4), rng.Uniform(0.1, 1.4), rng.Uniform(0.2, 1.2)};
  }
};

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

TEST(Detector, FindsWallsOfACellWithinWhatItStatesAndNoPipes) {
  Bench bench;
  const World cell = Cell();
  double nees = 0;
  int planes = 0;
  constexpr int kFrames = 500;
  for (int k = 0; k < kFrames; ++k) {
    SCOPED_TRACE(k);
    bench.Look(cell, bench.Eye(), bench.Target());
    for (const DetectedPipe& pipe : bench.detector->pipes()) {
      ADD_FAILURE() << "a pipe of radius " << pipe.fit.radius_m << ", length "
                    << pipe.hi_m - pipe.lo_m << ", readings " << pipe.fit.count << ", chi2 "
                    << pipe.fit.chi2 << ", p_S " << pipe.fit.p_S.transpose() << ", l_S "
                    << pipe.fit.l_S.transpose();
    }
    EXPECT_GE(bench.detector->planes().size(), 1);
    const Matrix3d R_SW = bench.cloud->X_WS.linear().transpose();
    for (const DetectedPlane& plane : bench.detector->planes()) {
      double least = 1e9;
      Vec<4> error = Vec<4>::Zero();
      for (const TruePlane& truth : cell.planes) {
        const Vector3d n_S = R_SW * truth.n_W;
        const double d = truth.d_m - truth.n_W.dot(bench.cloud->X_WS.translation());
        Vec<4> e;
        e << plane.fit.n_S - n_S, plane.fit.d_m - d;
        if (e.head<3>().norm() + std::abs(e(3)) < least) {
          least = e.head<3>().norm() + std::abs(e(3));
          error = e;
        }
      }
      EXPECT_LT(least, 0.15) << "a plane where there is none";
      nees += Nees<4>(error, plane.fit.covariance, 3);
      ++planes;
    }
  }
  RecordProperty("planes", planes);
  RecordProperty("mean_nees_milli", static_cast<int>(1000 * nees / planes));
  std::printf("planes %d, mean NEES %.3f of 3\n", planes, nees / planes);
  EXPECT_GT(planes, 1.5 * kFrames);
  EXPECT_NEAR(nees / planes, 3, 0.6);
}

TEST(Detector, FindsFarWallsWithinWhatItStates) {
  Bench bench;
  World hall;
  hall.planes = {{Vector3d::UnitX(), -2.6}, {-Vector3d::UnitZ(), -2.5}, {Vector3d::UnitY(), -2.4}};
  double nees = 0;
  int planes = 0;
  int bad = 0;
  for (int k = 0; k < 500; ++k) {
    const Vector3d eye(bench.rng.Uniform(-0.5, 0.8), bench.rng.Uniform(-0.5, 0.8), 0.6);
    const Vector3d target(-2.6, bench.rng.Uniform(-2.4, 1.0), bench.rng.Uniform(0.0, 2.5));
    bench.Look(hall, eye, target);
    const Isometry3d& X_WS = bench.cloud->X_WS;
    for (const DetectedPlane& plane : bench.detector->planes()) {
      const Vector3d n_W = X_WS.linear() * plane.fit.n_S;
      int which = 0;
      n_W.cwiseAbs().maxCoeff(&which);
      const TruePlane& truth = hall.planes[which == 0 ? 0 : 3 - which];
      Vec<4> error;
      error << plane.fit.n_S - X_WS.linear().transpose() * truth.n_W,
          plane.fit.d_m - (truth.d_m - truth.n_W.dot(X_WS.translation()));
      const double of_this = Nees<4>(error, plane.fit.covariance, 3);
      nees += of_this;
      bad += of_this > 21.1;  // the quantile 0.9999 of chi-square with 3 degrees of freedom
      ++planes;
    }
  }
  std::printf("far planes %d, mean NEES %.3f of 3, %d beyond 0.9999\n", planes, nees / planes, bad);
  EXPECT_GT(planes, 400);
  EXPECT_NEAR(nees / planes, 3, 0.6);
  EXPECT_LE(bad, planes / 200);
}

TEST(Detector, FindsPipesWithinWhatItStates) {
  Bench bench;
  double nees = 0;
  int found = 0;
  int wrong = 0;
  constexpr int kFrames = 600;
  for (int k = 0; k < kFrames; ++k) {
    World world = Cell();
    const double r = bench.rng.Uniform(0.03, 0.09);
    const Vector3d from(1.1, bench.rng.Uniform(0.3, 1.2), 0);
    const Vector3d to(bench.rng.Uniform(0.9, 1.2), bench.rng.Uniform(0.3, 1.2), 1.5);
    world.pipes = {{from, to, r}};
    const Vector3d middle = from + 0.55 * (to - from);
    const Vector3d eye = middle - Vector3d(bench.rng.Uniform(0.4, 0.8), 0, 0) +
                         0.2 * Vector3d(0, bench.rng.Normal(), bench.rng.Normal());
    bench.Look(world, eye, middle);
    const Isometry3d X_SW = bench.cloud->X_WS.inverse();
    const Vector3d l = X_SW.linear() * (to - from).normalized();
    for (const DetectedPipe& pipe : bench.detector->pipes()) {
      const CylinderFit& fit = pipe.fit;
      const Vector3d l_true = fit.l_S.dot(l) < 0 ? Vector3d(-l) : l;
      const Vector3d p0 = X_SW * from;
      const Vector3d at = p0 + fit.l_S.dot(fit.p_S - p0) / fit.l_S.dot(l_true) * l_true;
      Vec<7> error;
      error << fit.p_S - at, fit.l_S - l_true, fit.radius_m - r;
      if (error.head<3>().norm() > 0.03 || error.segment<3>(3).norm() > 0.2) {
        ++wrong;
        continue;
      }
      nees += Nees<7>(error, fit.covariance, 5);
      ++found;
    }
  }
  std::printf("found %d of %d, wrong %d, mean NEES %.3f of 5\n", found, kFrames, wrong,
              nees / found);
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(found, 0.9 * kFrames);
  EXPECT_NEAR(nees / found, 5, 1.0);
}

TEST(Detector, TakesABigPipeForNoPlaneAndAColumnTooThickForNoPipe) {
  Bench bench;
  for (const double r : {0.1, 0.15, 0.3, 0.5}) {
    for (int k = 0; k < 20; ++k) {
      SCOPED_TRACE(testing::Message() << "radius " << r << ", frame " << k);
      World world = Cell();
      world.planes.pop_back();
      world.pipes = {{{1.2, 0.75, 0}, {1.2, 0.75, 1.5}, r}};
      const double distance = r + bench.rng.Uniform(0.3, 0.8);
      bench.Look(world, {1.2 - distance, 0.75, 0.8}, {1.2, 0.75, 0.7});
      for (const DetectedPlane& plane : bench.detector->planes()) {
        const Vector3d n = bench.cloud->X_WS.linear() * plane.fit.n_S;
        EXPECT_GT(n.cwiseAbs().maxCoeff(), 0.99);
        const double d = plane.fit.d_m + n.dot(bench.cloud->X_WS.translation());
        EXPECT_GT(std::abs(std::abs(d) - (1.2 - r)), 0.03) << "a plane before the pipe";
      }
      for (const DetectedPipe& pipe : bench.detector->pipes()) {
        EXPECT_NEAR(pipe.fit.radius_m, r, 0.02);
      }
      if (r > 0.2) {
        EXPECT_EQ(bench.detector->pipes().size(), 0);
      }
    }
  }
}

TEST(Detector, MakesNeitherOfBalls) {
  Bench bench;
  for (int k = 0; k < 50; ++k) {
    SCOPED_TRACE(k);
    World world = Cell();
    world.balls = {{{1.0, 0.6, 0.7}, bench.rng.Uniform(0.05, 0.15)}};
    bench.Look(world, {0.4, 0.7, 0.8}, {1.0, 0.6, 0.7});
    for (const DetectedPipe& pipe : bench.detector->pipes()) {
      ADD_FAILURE() << "a pipe of radius " << pipe.fit.radius_m;
    }
  }
}

TEST(Detector, SurvivesEmptyTinyAndSillyFrames) {
  Bench bench;
  bench.cloud->width = 106;
  bench.cloud->height = 60;
  EXPECT_EQ(bench.view->Set(*bench.cloud, bench.config.noise), Status::kMalformed);  // no reading
  bench.cloud->width = 1;
  EXPECT_EQ(bench.view->Set(*bench.cloud, bench.config.noise), Status::kMalformed);
  bench.Look(Cell(), {0.5, 0.7, 0.8}, {1.5, 0.7, 0.8});
  for (int i = 0; i < bench.cloud->size(); ++i) {  // noise and nothing else
    const auto z = static_cast<float>(bench.rng.Uniform(0.2, 3));
    bench.cloud->p_SQ[i] *= z / bench.cloud->p_SQ[i].z();
  }
  ASSERT_EQ(bench.view->Set(*bench.cloud, bench.config.noise), Status::kOk);
  bench.detector->Detect(*bench.view, {});
  EXPECT_EQ(bench.detector->planes().size(), 0);
  EXPECT_EQ(bench.detector->pipes().size(), 0);
  const float nan = std::nanf("");
  for (int i = 0; i < bench.cloud->size(); i += 3) {
    bench.cloud->p_SQ[i] = {nan, 0, 1};
  }
  ASSERT_EQ(bench.view->Set(*bench.cloud, bench.config.noise), Status::kOk);
  bench.detector->Detect(*bench.view, {});
}

}  // namespace
}  // namespace pipewright
