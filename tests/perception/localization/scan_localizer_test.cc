// SPDX-License-Identifier: MIT
#include "perception/localization/scan_localizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

struct Wall {
  Vector3d n;
  double d;
};

const std::vector<Wall> kCell = {{Vector3d::UnitZ(), 0},
                                 {-Vector3d::UnitX(), -1.5},
                                 {Vector3d::UnitY(), -0.7},
                                 {-Vector3d::UnitY(), -0.8}};

constexpr int kWidth = 106;
constexpr int kHeight = 60;
constexpr double kFocal_px = 56;
constexpr double kNoise_1pm = 3.8e-3;

/// A camera at 0.8 m that looks forward and a bit down and aside.
Isometry3d Mount(double pan_rad) {
  Isometry3d X_BS = Isometry3d::Identity();
  Matrix3d R;  // z forward, x to the right, y down
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X_BS.linear() = Eigen::AngleAxisd(pan_rad, Vector3d::UnitZ()).toRotationMatrix() *
                  Eigen::AngleAxisd(0.3, Vector3d::UnitY()).toRotationMatrix() * R;
  X_BS.translation() << 0.2, 0, 0.8;
  return X_BS;
}

void See(const std::vector<Wall>& walls, const Isometry3d& X_WS, Time stamp, Rng& rng,
         Cloud& cloud) {
  cloud.stamp = stamp;
  cloud.width = kWidth;
  cloud.height = kHeight;
  cloud.valid_count = 0;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const Vector3d ray((i % kWidth - kWidth / 2) / kFocal_px,
                       (i / kWidth - kHeight / 2) / kFocal_px, 1);
    const Vector3d ray_W = X_WS.linear() * ray;
    double z = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls) {
      const double towards = -wall.n.dot(ray_W);
      if (towards > 1e-9) {
        z = std::min(z, (wall.n.dot(X_WS.translation()) - wall.d) / towards);
      }
    }
    cloud.valid[i] = z < 6;
    if (cloud.valid[i] != 0) {
      cloud.p_SQ[i] = ((z + kNoise_1pm * z * z * rng.Normal()) * ray).cast<float>();
      ++cloud.valid_count;
    }
  }
}

/// Standard deviations of a guess, in m and rad.
constexpr double kSure = 1e-3;
constexpr double kOnTheWay = 4e-3;
constexpr double kSlipped = 0.05;
constexpr double kSpilled = 0.15;

BasePose Guess(const Vector3d& pose, double sigma) {
  BasePose guess{.x_m = pose.x(), .y_m = pose.y(), .phi_rad = pose.z()};
  guess.covariance = Vector3d::Constant(sigma * sigma).asDiagonal();
  return guess;
}

class ScanLocalizerTest : public testing::Test {
 protected:
  Status Look(const Vector3d& truth, const Vector3d& guess, double pan_rad, double sigma = kSure,
              bool doubted = false, double worst = kSpilled) {
    now_ += std::chrono::milliseconds(67);
    See(kCell, BaseAt(truth) * Mount(pan_rad), now_, rng_, *cloud_);
    return localizer_->Step(*cloud_, Mount(pan_rad), Guess(guess, sigma), doubted,
                            Guess(guess, worst).covariance, fix_);
  }

  Rng rng_{9};
  Time now_{};
  std::unique_ptr<Cloud> cloud_ = std::make_unique<Cloud>();
  std::unique_ptr<ScanLocalizer> localizer_ = std::make_unique<ScanLocalizer>();
  PoseFix fix_;
};

TEST_F(ScanLocalizerTest, TakesTheFirstFrameForGrantedAndFindsItselfInTheNext) {
  EXPECT_EQ(Look(Vector3d::Zero(), Vector3d::Zero(), 0), Status::kUnavailable);
  EXPECT_TRUE(localizer_->added());
  EXPECT_GT(localizer_->map().cells(), 100);
  int ok = 0;
  for (int k = 0; k < 30; ++k) {
    ok += Look(Vector3d::Zero(), Vector3d::Zero(), 0) == Status::kOk;
  }
  EXPECT_GT(ok, 20);
  EXPECT_TRUE(localizer_->added());
  EXPECT_EQ(fix_.stamp, now_);
  EXPECT_LT(fix_.pose.head<2>().norm(), 2e-3);
  EXPECT_EQ(localizer_->counters().scans, 31U);
  EXPECT_EQ(localizer_->counters().unknown + localizer_->counters().fixes, 31U);
}

/// Round the cell by wheels that tell 5 % too little turn and 2 % too much way, each guess being
/// the last fix and what they tell: the error must not add up.
TEST_F(ScanLocalizerTest, DoesNotDriftOnAWayThatItsGuessesMisjudge) {
  Vector3d truth = Vector3d::Zero();
  Vector3d guess = Vector3d::Zero();
  Vector3d by_wheels = Vector3d::Zero();
  double worst_m = 0;
  double worst_rad = 0;
  for (int k = 0; k < 400; ++k) {
    const double v = k < 30 ? 0 : 0.012 * std::sin(0.05 * k);
    const double w = k < 30 ? 0 : 0.015 * std::cos(0.031 * k);
    truth += Vector3d(0.98 * v * std::cos(truth.z()), 0.98 * v * std::sin(truth.z()), 1.05 * w);
    guess += Vector3d(v * std::cos(guess.z()), v * std::sin(guess.z()), w);
    by_wheels += Vector3d(v * std::cos(by_wheels.z()), v * std::sin(by_wheels.z()), w);
    const double sigma = k < 30 ? kSure : kOnTheWay;
    if (Look(truth, guess, 0.5 * std::sin(0.07 * k), sigma) == Status::kOk) {
      guess = localizer_->pose();
    }
    worst_m = std::max(worst_m, (guess - truth).head<2>().norm());
    worst_rad = std::max(worst_rad, std::abs(guess.z() - truth.z()));
  }
  EXPECT_LT(worst_m, 0.01);
  EXPECT_LT(worst_rad, 0.5 * M_PI / 180);
  EXPECT_EQ(localizer_->counters().refused, 0U);
  EXPECT_GT(std::abs(by_wheels.z() - truth.z()) + (by_wheels - truth).head<2>().norm(), 0.02)
      << "the wheels alone must fail this";
}

/// A wall that leaves the range: of the readings at its limit half are beyond, and those that noise
/// draws near are not the wall's place.
TEST_F(ScanLocalizerTest, PlacesASurfaceAtItsLimitOfRangeWhereItIs) {
  const std::vector<Wall> back = {{-Vector3d::UnitX(), -2.48}};
  const Vector3d eye = Mount(0).translation();
  const double limit_m = ScanLocalizerConfig{}.range_m;
  for (int k = 0; k < 60; ++k) {
    See(back, Mount(0), now_ += std::chrono::milliseconds(67), rng_, *cloud_);
    (void)localizer_->Step(*cloud_, Mount(0), {}, false, Mat<3, 3>::Zero(), fix_);
  }
  double sum_m = 0;
  int count = 0;
  for (double y = -2; y < 2; y += 0.05) {
    for (double z = -1; z < 2; z += 0.05) {
      const Vector3d q(2.48, y, z);
      const Surfel* surfel = localizer_->map().Find(q);
      if (surfel != nullptr && std::abs((q - eye).norm() - limit_m) < 0.04) {
        sum_m += surfel->p_W.x() - q.x();
        ++count;
      }
    }
  }
  ASSERT_GT(count, 20);
  EXPECT_LT(std::abs(sum_m / count), 4e-3);
}

TEST_F(ScanLocalizerTest, AFixFarFromItsGuessPlacesNothing) {
  for (int k = 0; k < 40; ++k) {
    (void)Look(Vector3d::Zero(), Vector3d::Zero(), 0);
  }
  const int cells = localizer_->map().cells();
  const Vector3d pushed(0.06, 0.02, 0);
  ASSERT_EQ(Look(pushed, Vector3d::Zero(), 0, kSlipped), Status::kOk);
  EXPECT_NEAR(fix_.pose.x(), 0.06, 4e-3);
  EXPECT_FALSE(localizer_->added());
  EXPECT_EQ(localizer_->counters().jumps, 1U);
  EXPECT_EQ(localizer_->map().cells(), cells);
}

/// As after a slip that nobody saw: too far for the first try.
TEST_F(ScanLocalizerTest, FindsItselfAgain) {
  for (int k = 0; k < 60; ++k) {
    (void)Look(Vector3d::Zero(), Vector3d::Zero(), 0.4 * std::sin(0.3 * k));
  }
  for (const double turn : {-0.08, 0.08}) {
    const Vector3d slipped(0.03, -0.02, turn);
    ASSERT_EQ(Look(slipped, Vector3d::Zero(), 0, kSlipped), Status::kOk) << turn;
    EXPECT_LT((fix_.pose - slipped).head<2>().norm(), 8e-3) << turn;
    EXPECT_NEAR(fix_.pose.z(), turn, 8e-3);
    EXPECT_FALSE(localizer_->added());
  }
}

/// By a whole spill: the guess is far off and thinks itself sure. In doubt, it is looked for, as
/// far as the wheels may have slipped.
TEST_F(ScanLocalizerTest, AGuessInDoubtIsFoundFromFarAndPlacesNothing) {
  for (int k = 0; k < 60; ++k) {
    (void)Look(Vector3d::Zero(), Vector3d::Zero(), 0.4 * std::sin(0.3 * k));
  }
  int cells = 0;
  const std::uint64_t jumps = localizer_->counters().jumps;
  for (const Vector3d& slipped : {Vector3d(0.06, -0.04, -0.3), Vector3d(-0.1, 0.1, 0.25)}) {
    const bool near = Look(slipped, Vector3d::Zero(), 0, kSure) == Status::kOk &&
                      (fix_.pose - slipped).norm() < 0.01;
    EXPECT_FALSE(near) << "or it is not far";
    cells = localizer_->map().cells();
    ASSERT_EQ(Look(slipped, Vector3d::Zero(), 0, kSure, true), Status::kOk);
    EXPECT_LT((fix_.pose - slipped).head<2>().norm(), 8e-3);
    EXPECT_NEAR(fix_.pose.z(), slipped.z(), 8e-3);
    EXPECT_FALSE(localizer_->added());
  }
  EXPECT_GT(localizer_->counters().jumps, jumps);
  // Where no wheel can have slipped, it is not looked for there.
  const Vector3d far(-0.1, 0.1, 0.25);
  const bool found = Look(far, Vector3d::Zero(), 0, kSure, true, kSure) == Status::kOk &&
                     (fix_.pose - far).norm() < 0.05;
  EXPECT_FALSE(found);
  // Nor is one that finds itself where it was thought to be, or that sees nothing known.
  EXPECT_EQ(Look(Vector3d::Zero(), Vector3d::Zero(), 0, kSure, true), Status::kOk);
  EXPECT_FALSE(localizer_->added());
  EXPECT_EQ(Look({9, 9, 0}, {9, 9, 0}, 0, kSure, true), Status::kUnavailable);
  EXPECT_FALSE(localizer_->added());
  EXPECT_EQ(localizer_->map().cells(), cells);
}

/// Half of what is known was placed 4 cm off by a base that thought itself sure. In doubt, a base
/// that goes on to see both halves gets rid of one, and finds itself.
TEST_F(ScanLocalizerTest, ForgetsWhatContradictsTheRestInTheEnd) {
  for (int k = 0; k < 60; ++k) {
    const bool off = k % 2 == 1;
    const double pan = off ? 0.9 : -0.5;
    (void)Look(Vector3d::Zero(), off ? Vector3d(0, 0.04, 0) : Vector3d::Zero(), pan);
  }
  int seen = 0;
  while (Look(Vector3d::Zero(), Vector3d::Zero(), 0.2, kSure, true) != Status::kOk && seen < 200) {
    ++seen;
  }
  EXPECT_LT(seen, 150);
  if (seen > 0) {
    EXPECT_GT(localizer_->counters().repairs, 0U);
  }
}

/// A pipe stands before the wall, nearly as far off it as its points may be: it never was one.
TEST_F(ScanLocalizerTest, RefutesAPipeThatContradictsTheRest) {
  const Vector3d near(0.5, 0, 0);   // where the noise is less than that
  constexpr double kPan_rad = 0.7;  // both walls in view
  for (int k = 0; k < 60; ++k) {
    (void)Look(near, near, kPan_rad);
  }
  ASSERT_EQ(Look(near, near, kPan_rad), Status::kOk);
  PipeEstimate pipe;
  pipe.id = 1;
  pipe.p_W = {1, 1.277, 0.7};
  pipe.l_W = Vector3d::UnitZ();
  pipe.radius_m = 0.5;
  pipe.extent_lo_m = -0.7;
  pipe.extent_hi_m = 0.7;
  pipe.frames_seen = 50;
  Scene scene;
  ASSERT_TRUE(scene.pipes.push_back(pipe));
  localizer_->Take(scene);
  ASSERT_EQ(Look(near, near, kPan_rad), Status::kFault) << "or the test is idle";
  int seen = 0;
  while (Look(near, near, kPan_rad, kSure, true) != Status::kOk && seen < 100) {
    localizer_->Take(scene);
    ++seen;
  }
  EXPECT_LT(seen, 50);
  EXPECT_GT(localizer_->counters().repairs, 0U);
  EXPECT_LT((fix_.pose - near).head<2>().norm(), 4e-3);
}

TEST_F(ScanLocalizerTest, AFrameThatDoesNotFitPlacesNothing) {
  for (int k = 0; k < 40; ++k) {
    (void)Look(Vector3d::Zero(), Vector3d::Zero(), 0);
  }
  const int cells = localizer_->map().cells();
  // Each reading is up to a tenth too short or too long.
  See(kCell, Mount(0), now_, rng_, *cloud_);
  for (int i = 0; i < cloud_->size(); ++i) {
    cloud_->p_SQ[i] *= 1 + static_cast<float>(rng_.Uniform(-0.1, 0.1));
  }
  const Status status = localizer_->Step(*cloud_, Mount(0), Guess(Vector3d::Zero(), kSlipped),
                                         false, Mat<3, 3>::Zero(), fix_);
  EXPECT_TRUE(status == Status::kFault || status == Status::kIterationLimit) << Name(status);
  EXPECT_EQ(localizer_->counters().refused, 1U);
  EXPECT_EQ(localizer_->map().cells(), cells);
}

}  // namespace
}  // namespace pipewright
