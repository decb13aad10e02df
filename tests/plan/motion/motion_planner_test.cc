// SPDX-License-Identifier: MIT
#include "plan/motion/motion_planner.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <optional>

#include "plan/motion/inverse_kinematics.h"
#include "tests/plan/motion/allocation_count.h"
#include "tests/plan/motion/cell.h"

namespace pipewright {
namespace {

class PlannerInCell : public testing::Test {
 protected:
  PlannerInCell() {
    cell_.AddThreePipes();
    start_ = test::Cell::Start();
  }

  std::optional<Configuration> RandomGoal(Rng& rng) const {
    const SensorTarget target{{rng.Uniform(0.2, 1.1), rng.Uniform(0.3, 1.2), rng.Uniform(0.3, 1.2)},
                              Vector3d{rng.Normal(), rng.Normal(), rng.Normal()}.normalized()};
    return Reach(CollisionChecker(cell_.around()), target, start_, rng);
  }

  /// Free at a finer step than the planner's own; between its checks a little nearer is allowed.
  void ExpectFree(const MotionPlanner::Path& path, int first) const {
    CollisionConfig nearer;
    nearer.slack_m = 0;
    nearer.margin_m = 0.03;
    const CollisionChecker checker(cell_.around(), nearer);
    for (int i = first; i < path.size(); ++i) {
      const Edge edge(path[i - 1], path[i], SpeedsOf(TracerUf7()));
      const int steps = edge.Steps(0.005, 0.0125);
      for (int k = 0; k <= steps; ++k) {
        ASSERT_TRUE(checker.Free(edge.At(1.0 * k / steps))) << "edge " << i << ", step " << k;
      }
    }
  }

  int FirstFree(const MotionPlanner::Path& path) const {
    const CollisionChecker checker(cell_.around());
    int i = 0;
    while (!checker.Free(path[i])) {
      ++i;
    }
    return i;
  }

  /// Share s - floor(s) of the edge from waypoint floor(s).
  static Configuration At(const MotionPlanner::Path& path, double s) {
    const int i = std::min(static_cast<int>(s), static_cast<int>(path.size()) - 2);
    return EdgeAt(path[i], path[i + 1], s - i);
  }

  test::Cell cell_;
  Configuration start_;
  MotionPlanner planner_;
  MotionPlanner::Path path_;
  double duration_s_ = 0;
};

TEST_F(PlannerInCell, WaysLeadFromStartToGoalWithoutTouching) {
  Rng rng(71);
  int planned = 0;
  int asked = 0;
  while (asked < 40) {
    const auto goal = RandomGoal(rng);
    if (!goal) {
      continue;
    }
    ++asked;
    const Status status = planner_.Plan(cell_.around(), start_, *goal, rng, path_, &duration_s_);
    if (status != Status::kOk) {
      continue;
    }
    ++planned;
    EXPECT_EQ(path_[0], start_);
    EXPECT_EQ(path_.back(), *goal);
    EXPECT_NEAR(duration_s_, PathDuration(path_), 1e-12);
    ExpectFree(path_, 1);
    start_ = *goal;
  }
  EXPECT_GE(planned, asked * 9 / 10);
}

TEST_F(PlannerInCell, AWallBetweenIsGoneAround) {
  // A post in front of the arm: the straight turn of the first joint would hit it.
  cell_.AddBox({0.85, 0.72, 0.0}, {0.90, 0.78, 1.4});
  start_.head<3>() << 0.2, 0.75, 0;
  Configuration from = start_;
  Configuration to = start_;
  from.tail<kArmJoints>() << 0.6, 0.3, 0, 1.2, 0, 0.9, 0;
  to.tail<kArmJoints>() << -0.6, 0.3, 0, 1.2, 0, 0.9, 0;
  const CollisionChecker checker(cell_.around());
  ASSERT_TRUE(checker.Free(from));
  ASSERT_TRUE(checker.Free(to));
  ASSERT_FALSE(checker.FreeEdge(from, to));
  Rng rng(72);
  ASSERT_EQ(planner_.Plan(cell_.around(), from, to, rng, path_, &duration_s_), Status::kOk);
  EXPECT_GT(path_.size(), 2);
  EXPECT_GT(duration_s_, Edge(from, to).duration_s());
  ExpectFree(path_, 1);
}

TEST_F(PlannerInCell, AStartInsideTheMarginsIsLedOut) {
  const CollisionChecker strict(cell_.around());
  Rng rng(73);
  int led_out = 0;
  for (int trial = 0; trial < 5000 && led_out < 5; ++trial) {
    Configuration from = start_;
    for (int i = 0; i < kArmJoints; ++i) {
      from(3 + i) += rng.Uniform(-1.2, 1.2);
    }
    const double clearance_m = strict.Clearance(from);
    if (strict.Free(from) || clearance_m < 0.01 || clearance_m > 0.03) {
      continue;
    }
    if (planner_.Plan(cell_.around(), from, start_, rng, path_, &duration_s_) != Status::kOk) {
      continue;
    }
    ++led_out;
    EXPECT_EQ(path_[0], from);
    const int out = FirstFree(path_);
    for (double s = 0; s <= out; s += 0.01) {
      EXPECT_GT(strict.Clearance(At(path_, s)), clearance_m - 0.01);
    }
    ExpectFree(path_, out + 1);
  }
  EXPECT_EQ(led_out, 5);
}

TEST_F(PlannerInCell, ABaseAlongsideAWallThatBecameKnownIsLedOut) {
  const double wall_y_m = 1.5;
  const double allowed_m = wall_y_m - planner_.config().collision.base_plane_m;
  for (const double inside_m : {0.0, 0.02, 0.05, 0.1}) {
    for (const double heading_rad : {0.0, 0.1, -0.1, 1.5}) {
      SCOPED_TRACE(testing::Message() << inside_m << " m inside, heading " << heading_rad);
      Configuration from = start_;
      from(1) = allowed_m + inside_m;
      from(2) = heading_rad;
      ASSERT_FALSE(CollisionChecker(cell_.around()).Free(from));
      Rng rng(77);
      ASSERT_EQ(planner_.Plan(cell_.around(), from, start_, rng, path_, &duration_s_), Status::kOk);
      EXPECT_EQ(path_[0], from);
      const int out = FirstFree(path_);
      for (double s = 0; s <= out; s += 0.01) {
        EXPECT_LE(At(path_, s)(1), from(1) + 1e-3) << "nearer to the wall";
      }
      ExpectFree(path_, out + 1);
    }
  }
}

TEST_F(PlannerInCell, SaysWhyThereIsNoWay) {
  Rng rng(74);
  Configuration nan = start_;
  nan(4) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(planner_.Plan(cell_.around(), start_, nan, rng, path_, &duration_s_),
            Status::kOutOfRange);
  EXPECT_EQ(planner_.Plan(cell_.around(), nan, start_, rng, path_, &duration_s_),
            Status::kOutOfRange);

  Configuration in_wall = start_;
  in_wall(0) = 1.4;
  EXPECT_EQ(planner_.Plan(cell_.around(), start_, in_wall, rng, path_, &duration_s_),
            Status::kInfeasible);
  EXPECT_EQ(planner_.Plan(cell_.around(), in_wall, start_, rng, path_, &duration_s_),
            Status::kInfeasible)
      << "a start deep in a wall cannot be left";
  EXPECT_TRUE(path_.empty());
}

TEST_F(PlannerInCell, AGoalBehindAWallTakesAllIterationsOrAllNodes) {
  test::Cell walled;
  walled.AddBox({0.75, -0.5, 0}, {0.8, 1.95, 1.65});
  start_(0) = 0.1;
  Configuration beyond = start_;
  beyond(0) = 1.4;
  const CollisionChecker checker(walled.around());
  ASSERT_TRUE(checker.Free(start_));
  ASSERT_TRUE(checker.Free(beyond));
  Rng rng(75);
  EXPECT_EQ(planner_.Plan(walled.around(), start_, beyond, rng, path_, &duration_s_),
            Status::kIterationLimit);
  MotionPlanner small({.node_capacity = 128, .iterations = 100000});
  EXPECT_EQ(small.Plan(walled.around(), start_, beyond, rng, path_, &duration_s_), Status::kFull);
}

TEST_F(PlannerInCell, TheSameSeedGivesTheSamePath) {
  Rng rng(76);
  for (int trial = 0; trial < 10; ++trial) {
    const auto goal = RandomGoal(rng);
    if (!goal) {
      continue;
    }
    MotionPlanner other;
    MotionPlanner::Path path;
    double duration_s = 0;
    Rng a(77);
    Rng b(77);
    const Status first = planner_.Plan(cell_.around(), start_, *goal, a, path_, &duration_s_);
    EXPECT_EQ(first, other.Plan(cell_.around(), start_, *goal, b, path, &duration_s));
    ASSERT_EQ(path.size(), path_.size());
    for (int i = 0; i < path.size(); ++i) {
      EXPECT_EQ(path[i], path_[i]);
    }
  }
}

TEST_F(PlannerInCell, PlanningTakesNoMemory) {
  Rng rng(78);
  const long before = test::AllocationCount();
  int planned = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const auto goal = RandomGoal(rng);
    planned += goal && planner_.Plan(cell_.around(), start_, *goal, rng, path_, &duration_s_) ==
                           Status::kOk;
  }
  EXPECT_EQ(test::AllocationCount(), before);
  EXPECT_GT(planned, 5);
}

}  // namespace
}  // namespace pipewright
