// SPDX-License-Identifier: MIT
#include "perception/primitives/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "platform/core/rng.h"

namespace pipewright {
namespace {

using Eigen::Vector3f;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Vector3f InBall(float radius_m, Rng& rng) {
  Vector3f p;
  do {
    for (int i = 0; i < 3; ++i) {
      p(i) = static_cast<float>(rng.Uniform(-radius_m, radius_m));
    }
  } while (p.norm() > radius_m);
  return p;
}

class ThinningTest : public testing::Test {
 protected:
  std::vector<int> Pick(const std::vector<Vector3f>& points, float width_m) {
    std::vector<int> picked(Thinning::kMaxPoints);
    picked.resize(thinning_->Pick(points, width_m, picked));
    return picked;
  }

  std::unique_ptr<Thinning> thinning_ = std::make_unique<Thinning>();
};

TEST_F(ThinningTest, LeavesAllFinitePointsThatThereIsRoomFor) {
  Rng rng(1);
  std::vector<Vector3f> points(Thinning::kMaxPoints);
  std::generate(points.begin(), points.end(), [&] { return InBall(0.01F, rng); });
  EXPECT_EQ(Pick(points, 1).size(), points.size());
  points[7] = {0, kNan, 0};
  points[8] = {kInf, 0, 0};
  EXPECT_EQ(Pick(points, 1).size(), points.size() - 2);
  EXPECT_TRUE(Pick({}, 1).empty());
}

TEST_F(ThinningTest, OfADenseBallAndASparseOneTheSparseKeepsItsPoints) {
  constexpr int kDense = 200000;
  constexpr int kSparse = 10000;
  Rng rng(2);
  std::vector<Vector3f> points;
  for (int i = 0; i < kDense; ++i) {
    points.push_back(InBall(0.5F, rng));
  }
  for (int i = 0; i < kSparse; ++i) {
    points.emplace_back(InBall(2, rng) + Vector3f(10, 0, 0));
  }
  const std::vector<int> picked = Pick(points, 0.001F);
  EXPECT_LE(picked.size(), Thinning::kMaxPoints);
  EXPECT_GE(picked.size(), Thinning::kMaxPoints / 2);  // by a quarter in width is by half in volume
  EXPECT_TRUE(std::is_sorted(picked.begin(), picked.end()));
  const auto sparse =
      std::count_if(picked.begin(), picked.end(), [](int i) { return i >= kDense; });
  EXPECT_GT(sparse, 0.9 * kSparse);
}

TEST_F(ThinningTest, EveryPointIsNearOneThatIsPicked) {
  Rng rng(3);
  std::vector<Vector3f> points(Thinning::kMaxPoints + 1);
  std::generate(points.begin(), points.end(), [&] { return InBall(1, rng); });
  constexpr float kWidth_m = 0.2F;  // room enough for the first width
  const std::vector<int> picked = Pick(points, kWidth_m);
  EXPECT_LT(picked.size(), 2000U);
  for (const Vector3f& p : points) {
    EXPECT_TRUE(std::any_of(picked.begin(), picked.end(), [&](int i) {
      return (points[i] - p).cwiseAbs().maxCoeff() <= kWidth_m;
    }));
  }
}

TEST_F(ThinningTest, PointsTooFarForTheGridAreNotPickedAndDoNoHarm) {
  std::vector<Vector3f> points(2 * Thinning::kMaxPoints, Vector3f(1, 2, 3));
  points[5] = {3e38F, 0, 0};
  points[6] = {kInf, kNan, -kInf};
  EXPECT_EQ(Pick(points, 0.01F), std::vector<int>{0});
}

}  // namespace
}  // namespace pipewright
