// SPDX-License-Identifier: MIT
#include "perception/localization/new_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "perception/cloud/cluster_finder.h"
#include "platform/core/rng.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

constexpr double kSigma_m = 0.004;

struct Box {
  Vector3d min_W;
  Vector3d max_W;
};

/// Range to the first side of a box ahead: its inside from within, as a room's, else its outside.
double Meet(const Box& box, const Vector3d& p_WS, const Vector3d& ray_W) {
  double in = -std::numeric_limits<double>::infinity();
  double out = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double a = (box.min_W(i) - p_WS(i)) / ray_W(i);
    const double b = (box.max_W(i) - p_WS(i)) / ray_W(i);
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  const bool meets = out > 0 && in < out;
  return !meets ? std::numeric_limits<double>::infinity() : in > 0 ? in : out;
}

const Box kRoom{{-1.51, -1.02, 0}, {1.53, 1.33, 2.01}};

/// Rays all round among the room's walls and what stands in it; its own noise along each.
std::vector<ScanPoint> Look(const std::vector<Box>& things, const Isometry3d& X_WS, int count,
                            Rng& rng) {
  std::vector<ScanPoint> scan;
  for (int i = 0; i < count; ++i) {
    const Vector3d ray_S = Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    const Vector3d ray_W = X_WS.linear() * ray_S;
    double range_m = Meet(kRoom, X_WS.translation(), ray_W);
    for (const Box& thing : things) {
      range_m = std::min(range_m, Meet(thing, X_WS.translation(), ray_W));
    }
    const double read_m = range_m + kSigma_m * rng.Normal();
    scan.push_back({(read_m * ray_S).cast<float>(), static_cast<float>(kSigma_m)});
  }
  return scan;
}

Isometry3d Eye(double x_m, double y_m) {
  Isometry3d X_WS = Isometry3d::Identity();
  X_WS.linear() = Eigen::AngleAxisd(0.4, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  X_WS.translation() << x_m, y_m, 0.9;
  return X_WS;
}

class NewPointsTest : public testing::Test {
 protected:
  NewPointsTest() {
    for (const Isometry3d& X_WS : {Eye(0, 0), Eye(0.4, -0.3)}) {
      for (const ScanPoint& point : Look({kKnown_}, X_WS, 150000, rng_)) {
        (void)map_->Add(X_WS * point.p_SQ.cast<double>(), point.sigma_m, X_WS.translation());
      }
    }
  }

  std::vector<int> New(const std::vector<ScanPoint>& scan, const Isometry3d& X_WS) const {
    std::vector<int> numbers(scan.size());
    const test::NoAllocScope no_heap;
    const int count = NewPoints(*map_, pipes_, scan, X_WS, {}, numbers);
    EXPECT_LE(count, numbers.size());
    std::fill(numbers.begin() + count, numbers.end(), -1);
    return numbers;
  }

  const Box kKnown_{{-1.2, 0.3, 0}, {-0.8, 0.7, 0.5}};
  Rng rng_{7};
  std::unique_ptr<SurfelMap> map_ = std::make_unique<SurfelMap>();
  PipeLandmarks pipes_;
};

TEST_F(NewPointsTest, AreFewInAPlaceThatIsKnownThoughThePoseIsABitOff) {
  Isometry3d X_WS = Eye(0.2, 0.1);
  const std::vector<ScanPoint> scan = Look({kKnown_}, X_WS, 20000, rng_);
  X_WS.pretranslate(Vector3d(0.004, -0.003, 0));
  const std::vector<int> found = New(scan, X_WS);
  // Not none: the map's two scans left places in the shadow of the thing that is known.
  EXPECT_LT(std::count_if(found.begin(), found.end(), [](int i) { return i >= 0; }), 30);
}

TEST_F(NewPointsTest, FormOneClusterOfEachThingThatCame) {
  // One in the open, on the floor; one that stands 6 cm before a wall, where cells have surfels.
  const Box came[] = {{{0.5, 0.4, 0}, {0.8, 0.8, 0.4}}, {{1.3, -0.6, 0.7}, {1.47, -0.2, 1.1}}};
  const Isometry3d X_WS = Eye(0.2, 0.1);
  const std::vector<ScanPoint> scan = Look({kKnown_, came[0], came[1]}, X_WS, 20000, rng_);
  const std::vector<int> found = New(scan, X_WS);
  std::vector<Eigen::Vector3f> points;
  int on_them = 0;
  int all_on_them = 0;
  const auto clear_of_edges = [&](const Vector3d& p_W) {
    // Off the floor, and so not within a cell of what was there before.
    return std::any_of(std::begin(came), std::end(came), [&](const Box& box) {
      return (p_W.array() > box.min_W.array() - 0.02).all() &&
             (p_W.array() < box.max_W.array() + 0.02).all() && p_W.z() > 0.1 && p_W.x() < 1.4;
    });
  };
  for (const ScanPoint& point : scan) {
    all_on_them += clear_of_edges(X_WS * point.p_SQ.cast<double>());
  }
  for (const int i : found) {
    if (i >= 0) {
      points.push_back(scan[i].p_SQ);
      on_them += clear_of_edges(X_WS * scan[i].p_SQ.cast<double>());
    }
  }
  EXPECT_GT(all_on_them, 400);
  EXPECT_EQ(on_them, all_on_them);
  const auto finder = std::make_unique<ClusterFinder>();
  ASSERT_EQ(finder->Find(points, {.reach_m = 0.1, .count_min = 30}), Status::kOk);
  ASSERT_EQ(finder->clusters().size(), 2);
  for (const Box& box : came) {
    const Vector3d middle_S = X_WS.inverse() * ((box.min_W + box.max_W) / 2);
    EXPECT_TRUE(std::any_of(
        finder->clusters().begin(), finder->clusters().end(), [&](const PointCluster& cluster) {
          return (cluster.centroid_S - middle_S).norm() < (box.max_W - box.min_W).norm() / 2;
        }));
  }
}

TEST_F(NewPointsTest, AreNoneOnAKnownPipe) {
  PipeEstimate pipe;
  pipe.p_W = {0, 0, 1};
  pipe.l_W = Vector3d::UnitZ();
  pipe.radius_m = 0.05;
  pipe.extent_lo_m = -0.5;
  pipe.extent_hi_m = 0.5;
  pipe.frames_seen = 50;
  Scene scene;
  ASSERT_TRUE(scene.pipes.push_back(pipe));
  const Isometry3d X_WS = Eye(0.5, 0);
  const auto at = [&](const Vector3d& p_W) {
    return ScanPoint{(X_WS.inverse() * p_W).cast<float>(), static_cast<float>(kSigma_m)};
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<ScanPoint> scan{at({0.05, 0, 0.9}),
                                    at({0.065, 0, 0.9}),
                                    at({0.09, 0, 0.9}),
                                    at({0.05, 0, 1.55}),
                                    {{nan, 0, 0}, 0.01F}};
  EXPECT_EQ(New(scan, X_WS), (std::vector<int>{0, 1, 2, 3, -1}));
  pipes_.Update(scene);
  EXPECT_EQ(New(scan, X_WS), (std::vector<int>{2, 3, -1, -1, -1}));
}

}  // namespace
}  // namespace pipewright
