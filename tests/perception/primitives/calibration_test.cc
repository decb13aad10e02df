// SPDX-License-Identifier: MIT
// Whether what the detector finds is as far off as it says. `scripts/bench primitives` asks the
// same over more frames, of the emulated camera.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>
#include <vector>

#include "perception/primitives/detector.h"
#include "perception/primitives/track.h"
#include "seen_world.h"
#include "tests/support/chi_square.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using test::Calibrate;
using test::Calibration;
using test::LookingAt;
using test::World;

template <int n>
double Nees(const Vec<n>& error, const Mat<n, n>& covariance) {
  return error.dot(Eigen::LDLT<Mat<n, n>>(covariance).solve(error));
}

void ExpectWithin(const Calibration& c) {
  EXPECT_TRUE(c.within()) << c.count << " draws: mean " << c.mean.value << " in " << c.mean.lo
                          << " ... " << c.mean.hi << ", quantiles " << c.p50.value << " "
                          << c.p90.value << " " << c.p99.value;
}

TEST(KeptInformation, IsTheVarianceOfWhatIsKept) {
  Rng rng(2);
  for (const double c : {1.5, 2.0, 3.0, 4.0}) {
    double squares = 0;
    int kept = 0;
    for (int k = 0; k < 200000; ++k) {
      const double x = rng.Normal();
      if (std::abs(x) < c) {
        squares += x * x;
        ++kept;
      }
    }
    EXPECT_NEAR(KeptInformation(c), squares / kept, 0.01) << c;
  }
  EXPECT_EQ(KeptInformation(1e9), 1);
}

TEST(Calibration, OfWallsAndAPipeHoldsAtNoiseLevelsAndLensesOfAllSorts) {
  struct {
    double c_1pm;
    test::Lens lens;
  } const cases[] = {{0.0038, {}},
                     {0.0019, {.width = 212, .height = 120, .fov_rad = 1.2}},
                     {0.0070, {.width = 120, .height = 90, .fov_rad = 1.0}}};
  std::vector<double> planes;
  std::vector<double> axes;
  std::vector<double> radii;
  Rng rng(31);
  const auto cloud = std::make_unique<Cloud>();
  const auto view = std::make_unique<DepthView>();
  for (const auto& c : cases) {
    PrimitiveConfig config;
    config.noise.c_1pm = c.c_1pm;
    const auto detector = std::make_unique<PrimitiveDetector>(config, 7);
    for (int frame = 0; frame < 250; ++frame) {
      World world = test::Cell();
      const double r = rng.Uniform(0.03, 0.12);
      const Vector3d from(rng.Uniform(0.8, 1.1), rng.Uniform(0.3, 1.2), 0.0);
      const Vector3d to(rng.Uniform(0.8, 1.1), rng.Uniform(0.3, 1.2), 1.5);
      world.pipes = {{from, to, r}};
      const Vector3d middle = from + rng.Uniform(0.4, 0.6) * (to - from);
      const Vector3d eye = middle - Vector3d(rng.Uniform(0.4, 1.0), 0, 0) +
                           0.1 * Vector3d(0, rng.Normal(), rng.Normal());
      const Isometry3d X_WS = LookingAt(eye, middle);
      test::See(world, X_WS, c.lens, config.noise, rng, *cloud);
      {
        const test::NoAllocScope no_heap;
        ASSERT_EQ(view->Set(*cloud, config.noise), Status::kOk);
        detector->Detect(*view, {});
      }
      const Isometry3d X_SW = X_WS.inverse();
      for (const DetectedPlane& plane : detector->planes()) {
        for (const test::TruePlane& truth : world.planes) {
          Vec<4> error;
          error << plane.fit.n_S - X_SW.linear() * truth.n_W,
              plane.fit.d_m - (truth.d_m - truth.n_W.dot(X_WS.translation()));
          if (error.head<3>().norm() + std::abs(error(3)) > 0.15) {
            continue;
          }
          Mat<3, 4> H = Mat<3, 4>::Zero();
          H.block<1, 3>(0, 0) = plane.e1_S.transpose();
          H.block<1, 3>(1, 0) = plane.e2_S.transpose();
          H.block<1, 3>(2, 0) = -plane.p_SCentroid.transpose();
          H(2, 3) = 1;
          planes.push_back(Nees<3>(H * error, H * plane.fit.covariance * H.transpose()));
        }
      }
      for (const DetectedPipe& pipe : detector->pipes()) {
        Vector3d l = X_SW.linear() * (to - from).normalized();
        l = pipe.fit.l_S.dot(l) < 0 ? Vector3d(-l) : l;
        const Vector3d p0 = X_SW * from;
        const Vector3d at = p0 + pipe.fit.l_S.dot(pipe.fit.p_S - p0) / pipe.fit.l_S.dot(l) * l;
        Vec<7> error;
        error << pipe.fit.p_S - at, pipe.fit.l_S - l, pipe.fit.radius_m - r;
        PipeEstimate estimate;
        estimate.l_W = pipe.fit.l_S;
        const Mat<7, 5> G = PipeTangent(estimate);
        const Vec<5> x = G.transpose() * error;
        const Mat<5, 5> P = G.transpose() * pipe.fit.covariance * G;
        axes.push_back(Nees<4>(x.head<4>(), P.topLeftCorner<4, 4>()));
        radii.push_back(x(4) * x(4) / P(4, 4));
      }
    }
  }
  EXPECT_GT(planes.size(), 800U);
  EXPECT_GT(axes.size(), 600U);
  // Twelve figures of one sample: in bands of 99 % one in nine samples would miss one.
  ExpectWithin(Calibrate(planes, 3, test::kTwoSided999));
  ExpectWithin(Calibrate(axes, 4, test::kTwoSided999));
  ExpectWithin(Calibrate(radii, 1, test::kTwoSided999));
}

}  // namespace
}  // namespace pipewright
