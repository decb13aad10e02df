// SPDX-License-Identifier: MIT
#include "perception/localization/scan_registration.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "platform/core/rng.h"
#include "tests/perception/localization/walls.h"

namespace pipewright {
namespace {

using test::Fill;
using test::kCorridor;
using test::kRoom;
using test::Look;
using test::Mount;
using test::Wall;

TEST(SurfelMap, FindsTheWallsWhereTheyAre) {
  Rng rng(1);
  const auto map = std::make_unique<SurfelMap>();
  Fill(*map, kRoom, Vector3d::Zero(), 0.005, rng);
  const Isometry3d X_WS = Mount();
  int found = 0;
  int asked = 0;
  for (const ScanPoint& point : Look(kRoom, X_WS, 2000, 1e-9, rng)) {
    const Vector3d p = X_WS * point.p_SQ.cast<double>();
    int beside = 0;  // walls within the reach of a cell and its neighbours
    const Wall* own = nullptr;
    for (const Wall& wall : kRoom) {
      const double away = std::abs(wall.n.dot(p) - wall.d);
      beside += away < 0.15;
      own = away < 1e-4 ? &wall : own;
    }
    const Surfel* surfel = map->Find(p);
    ++asked;
    if (surfel == nullptr || beside != 1 || own == nullptr) {
      continue;
    }
    ++found;
    EXPECT_GT(surfel->n_W.dot(own->n), std::cos(0.06));
    EXPECT_NEAR(own->n.dot(surfel->p_W), own->d, 0.004);
  }
  EXPECT_GT(found, asked / 2);
}

/// A wall on the border of two cells: each sees half of the noise, yet the surfels lie on the wall.
TEST(SurfelMap, IsNotTornByAWallOnTheBorderOfCells) {
  const auto map = std::make_unique<SurfelMap>();
  Rng rng(2);
  constexpr double kSigma_m = 0.006;
  const Vector3d eye(0, 0, 0.5);
  for (int i = 0; i < 40000; ++i) {
    const Vector3d p(1.5 + kSigma_m * rng.Normal(), rng.Uniform(-0.5, 0.5), rng.Uniform(0, 1));
    (void)map->Add(p, kSigma_m, eye);
  }
  double sum = 0;
  int count = 0;
  for (double y = -0.4; y < 0.4; y += 0.013) {
    for (const double x : {1.49, 1.51}) {
      const Surfel* surfel = map->Find({x, y, 0.5});
      ASSERT_NE(surfel, nullptr);
      EXPECT_NEAR(surfel->p_W.x(), 1.5, 0.0015) << "half of the noise alone has its mean at 4.8 mm";
      sum += surfel->p_W.x();
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 1.5, 3e-4);
}

TEST(SurfelMap, IsFrozenOnceItIsSure) {
  const auto map = std::make_unique<SurfelMap>(SurfelMapConfig{.count_max = 64});
  Rng rng(3);
  const auto add = [&](double x) {
    const Vector3d p(x, rng.Uniform(0, 0.3), rng.Uniform(0, 0.3));
    return map->Add(p, 0.002, Vector3d::Zero());
  };
  for (int i = 0; i < 20000; ++i) {
    ASSERT_EQ(add(1.025), Status::kOk);
  }
  const Surfel before = *map->Find({1.025, 0.125, 0.125});
  for (int i = 0; i < 20000; ++i) {
    ASSERT_EQ(add(1.035), Status::kOk);
  }
  EXPECT_EQ(map->Find({1.025, 0.125, 0.125})->p_W, before.p_W);
}

/// A base that was unsure of itself put a wall 4 cm off; a sure one puts it where it is.
TEST(SurfelMap, IsBegunAnewWhereItIsPlacedBetter) {
  const auto map = std::make_unique<SurfelMap>();
  Rng rng(6);
  const Vector3d eye(0, 0, 0.5);
  const auto see = [&](double x_m, const Placement& placed) {
    for (int i = 0; i < 40000; ++i) {
      const Vector3d p(x_m + 0.001 * rng.Normal(), rng.Uniform(-0.5, 0.5), rng.Uniform(0, 1));
      (void)map->Add(p, 0.001, eye, placed);
    }
  };
  const Placement unsure{.m2 = 4e-4, .rad2 = 4e-4};
  const Placement sure{.m2 = 1e-6, .rad2 = 1e-6};
  see(1.53, unsure);
  ASSERT_NE(map->Find({1.53, 0.02, 0.52}), nullptr);
  EXPECT_NEAR(map->Find({1.53, 0.02, 0.52})->placed.m2, unsure.m2, 1e-9);
  see(1.51, sure);
  const Surfel* surfel = map->Find({1.51, 0.02, 0.52});
  ASSERT_NE(surfel, nullptr);
  EXPECT_NEAR(surfel->p_W.x(), 1.51, 1e-3);
  EXPECT_NEAR(surfel->placed.m2, sure.m2, 1e-9);
  see(1.53, unsure);  // frozen by then, and no better
  EXPECT_NEAR(map->Find({1.51, 0.02, 0.52})->p_W.x(), 1.51, 1e-3);
}

TEST(SurfelMap, ForgetsACell) {
  const auto map = std::make_unique<SurfelMap>();
  Rng rng(7);
  const auto see = [&] {
    for (int i = 0; i < 4000; ++i) {
      const Vector3d p(1.02 + 1e-3 * rng.Normal(), rng.Uniform(-0.3, 0.3), rng.Uniform(0, 0.6));
      ASSERT_EQ(map->Add(p, 1e-3, Vector3d::Zero()), Status::kOk);
    }
  };
  const Vector3d on_wall(1.02, 0.02, 0.32);
  see();
  const int cells = map->cells();
  const Vector3d own = map->Find(on_wall)->p_W;
  map->Forget(on_wall);
  const Surfel* beside = map->Find(on_wall);
  ASSERT_NE(beside, nullptr);
  EXPECT_GT((beside->p_W - own).norm(), 0.02) << "a neighbour's";
  EXPECT_EQ(map->cells(), cells) << "its room is kept";
  map->Forget({50, 0, 0});
  see();
  EXPECT_LT((map->Find(on_wall)->p_W - own).norm(), 0.01);
}

TEST(SurfelMap, RefusesWhatIsNoPointAndWhatItHasNoRoomFor) {
  const auto map = std::make_unique<SurfelMap>();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(map->Add({nan, 0, 0}, 0.01, Vector3d::Zero()), Status::kOutOfRange);
  EXPECT_EQ(map->Add({1e9, 0, 0}, 0.01, Vector3d::Zero()), Status::kOutOfRange);
  EXPECT_EQ(map->Add({1, 0, 0}, 0, Vector3d::Zero()), Status::kOutOfRange);
  EXPECT_EQ(map->Add({1, 0, 0}, nan, Vector3d::Zero()), Status::kOutOfRange);
  EXPECT_EQ(map->cells(), 0);
  for (int i = 0; i < SurfelMap::kMaxCells; ++i) {
    ASSERT_EQ(
        map->Add({0.05 * (i % 200) + 0.01, 0.05 * (i / 200) + 0.01, 0.01}, 0.01, Vector3d::Zero()),
        Status::kOk);
  }
  EXPECT_EQ(map->Add({-5, -5, 0}, 0.01, Vector3d::Zero()), Status::kFull);
  EXPECT_EQ(map->refused(), 1U);
  EXPECT_EQ(map->Add({0.01, 0.01, 0.01}, 0.01, Vector3d::Zero()), Status::kOk) << "a cell it has";
  map->Clear();
  EXPECT_EQ(map->cells(), 0);
  EXPECT_EQ(map->Find({0.01, 0.01, 0.01}), nullptr);
}

class Registration : public testing::Test {
 protected:
  Status FromGuess(const std::vector<ScanPoint>& scan, const Vector3d& guess) {
    return Register(*map_, pipes_, scan, Mount(), guess, guess, {}, fix_, figures_);
  }

  const std::unique_ptr<SurfelMap> map_ = std::make_unique<SurfelMap>();
  PipeLandmarks pipes_;
  Rng rng_{4};
  PoseFix fix_;
  RegistrationFigures figures_;
};

TEST_F(Registration, FindsThePoseThatTheScanWasTakenFrom) {
  Fill(*map_, kRoom, Vector3d::Zero(), 0.005, rng_);
  for (int trial = 0; trial < 40; ++trial) {
    const Vector3d truth(rng_.Uniform(-0.4, 0.4), rng_.Uniform(-0.4, 0.4), rng_.Uniform(-3, 3));
    const Vector3d off(rng_.Uniform(-0.04, 0.04), rng_.Uniform(-0.04, 0.04),
                       rng_.Uniform(-0.05, 0.05));
    const auto scan = Look(kRoom, BaseAt(truth) * Mount(), 1500, 0.005, rng_);
    ASSERT_EQ(FromGuess(scan, truth + off), Status::kOk) << trial;
    EXPECT_EQ(figures_.directions, 3);
    EXPECT_LT((fix_.pose - truth).head<2>().norm(), 2e-3) << trial;
    EXPECT_LT(std::abs(fix_.pose.z() - truth.z()), 2e-3) << trial;
  }
}

/// Against the exact normal equations of walls that are known: sum of n_i n_i' / σ² over points.
TEST_F(Registration, StatesTheInformationOfTheScansNoise) {
  constexpr double kSigma_m = 0.01;
  Fill(*map_, kRoom, Vector3d::Zero(), kSigma_m, rng_);
  constexpr int kTrials = 150;
  Mat<3, 3> spread = Mat<3, 3>::Zero();
  Mat<3, 3> stated = Mat<3, 3>::Zero();
  Vector3d mean = Vector3d::Zero();
  std::vector<Vector3d> errors;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Vector3d truth(0.1, -0.1, 0.2);
    const auto scan = Look(kRoom, BaseAt(truth) * Mount(), 600, kSigma_m, rng_);
    ASSERT_EQ(FromGuess(scan, truth), Status::kOk);
    errors.push_back(fix_.pose - truth);
    mean += errors.back() / kTrials;
    stated += fix_.information.inverse() / kTrials;
  }
  for (const Vector3d& error : errors) {
    spread += (error - mean) * (error - mean).transpose() / (kTrials - 1);
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(stated(i, i), 0.7 * spread(i, i)) << i;  // never much surer than it is
    EXPECT_LT(stated(i, i), 2.5 * spread(i, i)) << i;
    EXPECT_LT(std::abs(mean(i)), 2e-3) << "what all scans share: the map's own error";
  }
}

TEST_F(Registration, ACorridorHoldsTheBaseAcrossButNotAlong) {
  Fill(*map_, kCorridor, Vector3d::Zero(), 0.005, rng_);
  const Vector3d truth(0.3, 0.1, 0.1);
  const Vector3d guess = truth + Vector3d(0.05, 0.03, -0.03);
  const auto scan = Look(kCorridor, BaseAt(truth) * Mount(), 2000, 0.005, rng_);
  ASSERT_EQ(FromGuess(scan, guess), Status::kOk);
  EXPECT_EQ(figures_.directions, 2);
  EXPECT_NEAR(fix_.pose.y(), truth.y(), 2e-3);
  EXPECT_NEAR(fix_.pose.z(), truth.z(), 2e-3);
  EXPECT_NEAR(fix_.pose.x(), guess.x(), 5e-3);
  const double along = fix_.information(0, 0);
  EXPECT_LT(along, 1e-3 * fix_.information(1, 1));
}

TEST_F(Registration, AFloorAloneTellsNothingOfThePlane) {
  const std::vector<Wall> floor = {{Vector3d::UnitZ(), 0}};
  Fill(*map_, floor, Vector3d::Zero(), 0.005, rng_);
  const auto scan = Look(floor, Mount(), 2000, 0.005, rng_);
  EXPECT_EQ(FromGuess(scan, Vector3d::Zero()), Status::kInfeasible);
}

TEST_F(Registration, RefusesAScanOfAnotherPlaceAndOneOfTheUnknown) {
  Fill(*map_, kRoom, Vector3d::Zero(), 0.005, rng_);
  const auto scan = Look(kRoom, BaseAt({0.2, 0.1, 0}) * Mount(), 2000, 0.005, rng_);
  EXPECT_EQ(FromGuess(scan, {50, 0, 0}), Status::kUnavailable);
  EXPECT_EQ(FromGuess({}, Vector3d::Zero()), Status::kUnavailable);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(FromGuess(scan, {nan, 0, 0}), Status::kOutOfRange);

  // Each reading is up to a tenth too short or too long: there is no pose at which they fit.
  std::vector<ScanPoint> torn = scan;
  for (ScanPoint& point : torn) {
    point.p_SQ *= 1 + static_cast<float>(rng_.Uniform(-0.1, 0.1));
  }
  RegistrationConfig config;
  EXPECT_EQ(FromGuess(torn, {0.2, 0.1, 0}), Status::kIterationLimit);
  config.iterations = 200;
  EXPECT_EQ(
      Register(*map_, pipes_, torn, Mount(), {0.2, 0.1, 0}, {0.2, 0.1, 0}, config, fix_, figures_),
      Status::kFault);
}

/// The narrow end of a wall is seen beside the wall's face, which has surfels; it has none.
TEST_F(Registration, TakesAPointForItsOwnSurfaceOnly) {
  const std::vector<Wall> face = {{Vector3d::UnitY(), -1.02}};
  Fill(*map_, face, Vector3d::Zero(), 0.002, rng_);
  const Isometry3d X_WS = Mount();
  std::vector<ScanPoint> end;
  for (int i = 0; i < 300; ++i) {
    const Vector3d p(0.5, -1.02 - rng_.Uniform(0, 0.04), rng_.Uniform(0.2, 0.8));
    end.push_back({(X_WS.inverse() * p).cast<float>(), 0.002F,
                   (X_WS.linear().transpose() * -Vector3d::UnitX()).cast<float>()});
  }
  EXPECT_EQ(FromGuess(end, Vector3d::Zero()), Status::kUnavailable);
  EXPECT_EQ(figures_.associated, 0);
  for (ScanPoint& point : end) {
    point.n_S.setZero();  // nothing known: the wall's
  }
  (void)FromGuess(end, Vector3d::Zero());
  EXPECT_GT(figures_.associated, 100);
}

TEST_F(Registration, TellsHowSurelyItsSurroundingsWerePlaced) {
  const Placement unsure{.m2 = 3e-5, .rad2 = 2e-4};
  const Isometry3d X_WS = Mount();
  for (const ScanPoint& point : Look(kRoom, X_WS, 120000, 0.005, rng_)) {
    (void)map_->Add(X_WS * point.p_SQ.cast<double>(), point.sigma_m, X_WS.translation(), unsure);
  }
  ASSERT_EQ(FromGuess(Look(kRoom, X_WS, 1500, 0.005, rng_), Vector3d::Zero()), Status::kOk);
  EXPECT_NEAR(fix_.placed.m2, unsure.m2, 1e-3 * unsure.m2);
  EXPECT_NEAR(fix_.placed.rad2, unsure.rad2, 1e-3 * unsure.rad2);
}

/// The floor tells nothing of where the base stands, nor does how surely it was placed.
TEST_F(Registration, TellsNothingOfHowTheFloorWasPlaced) {
  const Isometry3d X_WS = Mount();
  constexpr Placement kSure{.m2 = 1e-6, .rad2 = 1e-6};
  constexpr Placement kUnsure{.m2 = 1e-4, .rad2 = 1e-3};
  const auto scan = Look(kRoom, X_WS, 1500, 0.005, rng_);
  Mat<3, 3> information[2];
  for (const bool sure_floor : {false, true}) {
    map_->Clear();
    for (const ScanPoint& point : Look(kRoom, X_WS, 120000, 0.005, rng_)) {
      const Vector3d p_W = X_WS * point.p_SQ.cast<double>();
      int beside = 0;
      for (const Wall& wall : kRoom) {
        beside += std::abs(wall.n.dot(p_W) - wall.d) < 0.12;
      }
      if (beside == 1) {  // no surfel is of both
        const bool sure = (p_W.z() < 0.12) == sure_floor;
        (void)map_->Add(p_W, point.sigma_m, X_WS.translation(), sure ? kSure : kUnsure);
      }
    }
    ASSERT_EQ(FromGuess(scan, Vector3d::Zero()), Status::kOk);
    const Placement& of_walls = sure_floor ? kUnsure : kSure;
    EXPECT_NEAR(fix_.placed.m2, of_walls.m2, 0.05 * of_walls.m2);
    EXPECT_NEAR(fix_.placed.rad2, of_walls.rad2, 0.05 * of_walls.rad2);
    information[sure_floor] = fix_.information;
  }
  EXPECT_LT((information[0] - information[1]).norm(), 0.2 * information[0].norm())
      << "walls that were placed alike tell alike";
}

/// Half of the room was placed by a base that was 4 degrees off, and knew that it might be: what it
/// placed before counts, and nothing contradicts it.
TEST_F(Registration, GoesByWhatWasPlacedWell) {
  const Isometry3d X_WS = Mount();
  const Isometry3d off = BaseAt({0.01, 0.02, 0.07}) * Mount();
  constexpr Placement kUnsure{.m2 = 4e-4, .rad2 = 5e-3};
  for (const ScanPoint& point : Look(kRoom, X_WS, 120000, 0.005, rng_)) {
    const bool left = point.p_SQ.y() > 0;
    (void)map_->Add((left ? off : X_WS) * point.p_SQ.cast<double>(), point.sigma_m,
                    X_WS.translation(), left ? kUnsure : Placement());
  }
  for (const Vector3d& guess : {Vector3d(0, 0, 0), Vector3d(0.01, -0.01, 0.02)}) {
    ASSERT_EQ(FromGuess(Look(kRoom, X_WS, 1500, 0.005, rng_), guess), Status::kOk);
    EXPECT_GT(figures_.inlier_share, 0.9);
    EXPECT_LT(fix_.pose.head<2>().norm(), 3e-3);
    EXPECT_LT(std::abs(fix_.pose.z()), 3e-3);
  }
}

TEST_F(Registration, OutliersDoNotMoveIt) {
  Fill(*map_, kRoom, Vector3d::Zero(), 0.005, rng_);
  const Vector3d truth(0.2, 0.1, 0.5);
  auto scan = Look(kRoom, BaseAt(truth) * Mount(), 2000, 0.005, rng_);
  for (std::size_t i = 0; i < scan.size(); i += 5) {
    scan[i].p_SQ *= 0.97F;  // a fifth of them short, all to the same side
  }
  ASSERT_EQ(FromGuess(scan, truth + Vector3d(0.02, -0.02, 0.02)), Status::kOk);
  EXPECT_LT((fix_.pose - truth).head<2>().norm(), 4e-3);
  EXPECT_LT(std::abs(fix_.pose.z() - truth.z()), 4e-3);
}

/// Along a corridor only the riser in it tells, as seen from one side.
TEST_F(Registration, APipeHoldsTheBaseWhereWallsDoNot) {
  Fill(*map_, kCorridor, Vector3d::Zero(), 0.005, rng_);
  PipeEstimate riser;
  riser.p_W = {1.2, 0.3, 0.5};
  riser.l_W = Vector3d::UnitZ();
  riser.radius_m = 0.06;
  riser.extent_lo_m = -0.6;
  riser.extent_hi_m = 1;
  riser.frames_seen = 100;
  Scene scene;
  ASSERT_TRUE(scene.pipes.push_back(riser));
  pipes_.Update(scene);
  const Vector3d truth(0.3, 0.1, 0.1);
  const Isometry3d X_WS = BaseAt(truth) * Mount();
  auto scan = Look(kCorridor, X_WS, 1000, 0.005, rng_);
  for (int i = 0; i < 300; ++i) {
    const double at_rad = rng_.Uniform(0.7 * M_PI, 1.3 * M_PI);  // the side towards the base
    const Vector3d n(std::cos(at_rad), std::sin(at_rad), 0);
    const Vector3d p = riser.p_W + 0.06 * n + Vector3d(0, 0, rng_.Uniform(-0.4, 0.6));
    const Vector3d ray = (p - X_WS.translation()).normalized();
    scan.push_back(
        {(X_WS.inverse() * Vector3d(p + 0.005 * rng_.Normal() * ray)).cast<float>(), 0.005F});
  }
  ASSERT_EQ(FromGuess(scan, truth + Vector3d(0.01, 0.01, -0.01)), Status::kOk);
  EXPECT_EQ(figures_.directions, 3);
  EXPECT_LT((fix_.pose - truth).head<2>().norm(), 3e-3);
  EXPECT_NEAR(fix_.pose.z(), truth.z(), 2e-3);
}

}  // namespace
}  // namespace pipewright
