// SPDX-License-Identifier: MIT
#include "perception/localization/pose_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/perception/localization/walls.h"

namespace pipewright {
namespace {

using test::Fill;
using test::kRoom;
using test::Mount;
using test::Wall;

class PoseSearch : public testing::Test {
 protected:
  PoseSearch() { Fill(*map_, kRoom, Vector3d::Zero(), 0.005, rng_); }

  /// With the normals that a camera gives.
  std::vector<ScanPoint> Look(const Vector3d& truth) {
    const Isometry3d X_WS = BaseAt(truth) * Mount();
    std::vector<ScanPoint> scan = test::Look(kRoom, X_WS, 1000, 0.005, rng_);
    for (ScanPoint& point : scan) {
      const Vector3d p_W = X_WS * point.p_SQ.cast<double>();
      const auto off = [&](const Wall& wall) { return std::abs(wall.n.dot(p_W) - wall.d); };
      const Wall& nearest =
          *std::min_element(kRoom.begin(), kRoom.end(),
                            [&](const Wall& a, const Wall& b) { return off(a) < off(b); });
      point.n_S = (X_WS.linear().transpose() * nearest.n).cast<float>();
    }
    return scan;
  }

  Rng rng_{8};
  const std::unique_ptr<SurfelMap> map_ = std::make_unique<SurfelMap>();
  const PipeLandmarks pipes_;
};

/// Wherever in its grid the base was carried, a registration from there finds it.
TEST_F(PoseSearch, BringsTheBaseWithinReachOfItsRegistration) {
  const PoseSearchConfig config;
  int near_alone = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Vector3d carried(rng_.Uniform(-config.way_m, config.way_m),
                           rng_.Uniform(-config.way_m, config.way_m),
                           rng_.Uniform(-config.turn_rad, config.turn_rad));
    const auto scan = Look(carried);
    const Vector3d start = BestStart(*map_, pipes_, scan, Mount(), Vector3d::Zero(), config);
    PoseFix fix;
    RegistrationFigures figures;
    const RegistrationConfig registration{.reach_m = config.width_m};
    ASSERT_EQ(
        Register(*map_, pipes_, scan, Mount(), Vector3d::Zero(), start, registration, fix, figures),
        Status::kOk)
        << carried.transpose();
    EXPECT_LT((fix.pose - carried).head<2>().norm(), 4e-3) << carried.transpose();
    EXPECT_LT(std::abs(fix.pose.z() - carried.z()), 4e-3) << carried.transpose();
    PoseFix by_guess;
    const bool found = Register(*map_, pipes_, scan, Mount(), Vector3d::Zero(), Vector3d::Zero(),
                                registration, by_guess, figures) == Status::kOk;
    near_alone += found && (by_guess.pose - carried).norm() < 0.01;
  }
  EXPECT_LT(near_alone, 20) << "or the search is not needed here";
}

TEST_F(PoseSearch, StaysWithAGuessThatIsAsGood) {
  const Vector3d off(0.01, -0.01, 0.01);
  EXPECT_EQ(BestStart(*map_, pipes_, Look(Vector3d::Zero()), Mount(), off), off);
  EXPECT_EQ(BestStart(*map_, pipes_, {}, Mount(), off), off) << "nothing seen";
  const auto elsewhere = std::make_unique<SurfelMap>();
  EXPECT_EQ(BestStart(*elsewhere, pipes_, Look(off), Mount(), off), off) << "nothing known";
}

}  // namespace
}  // namespace pipewright
