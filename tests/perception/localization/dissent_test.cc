// SPDX-License-Identifier: MIT
#include "perception/localization/dissent.h"

#include <gtest/gtest.h>

namespace pipewright {
namespace {

PoseFix FixAt(const Vector3d& pose, const Vector3d& information = {1e6, 1e6, 1e6}) {
  return {.pose = pose, .information = information.asDiagonal()};
}

class DissentTest : public testing::Test {
 protected:
  int Add(const PoseFix& fix, const Vector3d& pose = Vector3d::Zero()) {
    dissent_.Add(fix, pose, {});
    return dissent_.count();
  }

  Dissent dissent_;
};

TEST_F(DissentTest, CountsFixesOfOneOpinion) {
  EXPECT_EQ(dissent_.count(), 0);
  EXPECT_EQ(Add(FixAt({0.1, 0.2, 0.3})), 1);
  EXPECT_EQ(Add(FixAt({0.101, 0.199, 0.301})), 2);
  EXPECT_EQ(Add(FixAt({0.1, 0.2, 0.3})), 3);
  EXPECT_EQ(dissent_.offset(), Vector3d(0.1, 0.2, 0.3));
  dissent_.Clear();
  EXPECT_EQ(Add(FixAt({0.1, 0.2, 0.3})), 1);
}

TEST_F(DissentTest, OnesThatWanderAreEachAlone) {
  EXPECT_EQ(Add(FixAt({0.1, 0, 0})), 1);
  EXPECT_EQ(Add(FixAt({0.2, 0, 0})), 1);
  EXPECT_EQ(Add(FixAt({0.2, 0, 0.2})), 1);
  EXPECT_EQ(Add(FixAt({0.2, 0, 0.2})), 2);
}

/// What counts is the way from where the wheels have it, not the place.
TEST_F(DissentTest, FollowsAPoseThatMoves) {
  for (int k = 0; k < 4; ++k) {
    const Vector3d pose(0.3 * k, -0.1 * k, 0.5 * k);
    EXPECT_EQ(Add(FixAt(pose + Vector3d(0.1, 0, 0.1)), pose), k + 1);
  }
  EXPECT_EQ(Add(FixAt({0.1, 0, 0.1}), {0.3, 0, 0}), 1);
}

TEST_F(DissentTest, WhereAFixKnowsNothingItDoesNotDisagree) {
  EXPECT_EQ(Add(FixAt({0.1, 0, 0}, {1e6, 0, 1e6})), 1);
  EXPECT_EQ(Add(FixAt({0.1, 5, 0}, {1e6, 0, 1e6})), 2);
  EXPECT_EQ(Add(FixAt({5, 5, 0}, {1e6, 0, 1e6})), 1);
}

TEST_F(DissentTest, HeadingsMeetAcrossFullTurns) {
  EXPECT_EQ(Add(FixAt({0, 0, 3.1}), {0, 0, 2.9}), 1);
  EXPECT_EQ(Add(FixAt({0, 0, 3.1 - 2 * M_PI}), {0, 0, 2.9}), 2);
  EXPECT_NEAR(dissent_.offset().z(), 0.2, 1e-12);
}

}  // namespace
}  // namespace pipewright
