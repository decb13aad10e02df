// SPDX-License-Identifier: MIT
#include "perception/cloud/cluster_finder.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "platform/core/rng.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright {
namespace {

using Eigen::Vector3f;
using Points = std::vector<Vector3f>;

// rapidcheck reads its seed from the environment; unless someone sets another, it is this one.
const bool kSeeded = setenv("RC_PARAMS", "seed=20261122 max_success=1500", 0) == 0;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// The oracle: floods over all pairs. @returns the clusters' points, as clusters are to be ordered
std::vector<std::vector<int>> OfAllPairs(const Points& points, const ClusterConfig& config) {
  const auto n = static_cast<int>(points.size());
  const auto reach = [&](int i) {
    return std::max(static_cast<float>(config.reach_m),
                    static_cast<float>(config.spacing_rad) * points[i].norm());
  };
  std::vector<bool> reached(points.size());
  std::vector<std::vector<int>> clusters;
  for (int seed = 0; seed < n; ++seed) {
    if (reached[seed]) {
      continue;
    }
    reached[seed] = true;
    std::vector<int> members{seed};
    for (std::size_t next = 0; next < members.size(); ++next) {
      const int i = members[next];
      for (int j = 0; j < n; ++j) {
        const float least_m = std::min(reach(i), reach(j));
        if (!reached[j] && (points[j] - points[i]).squaredNorm() <= least_m * least_m) {
          reached[j] = true;
          members.push_back(j);
        }
      }
    }
    std::sort(members.begin(), members.end());
    if (static_cast<int>(members.size()) >= config.count_min) {
      clusters.push_back(members);
    }
  }
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return clusters;
}

class ClusterFinderTest : public testing::Test {
 protected:
  std::vector<std::vector<int>> Labelled() const {
    std::vector<std::vector<int>> clusters(finder_->clusters().size());
    for (int i = 0; i < static_cast<int>(finder_->labels().size()); ++i) {
      if (finder_->labels()[i] != ClusterFinder::kNone) {
        clusters.at(finder_->labels()[i]).push_back(i);
      }
    }
    return clusters;
  }

  /// What is said of each cluster, from its points.
  void ExpectMeasuresOf(const Points& points) const {
    const std::vector<std::vector<int>> labelled = Labelled();
    for (int k = 0; k < finder_->clusters().size(); ++k) {
      const PointCluster& cluster = finder_->clusters()[k];
      ASSERT_EQ(cluster.points, labelled[k].size());
      EXPECT_EQ(cluster.first, labelled[k].front());
      Vector3d mean = Vector3d::Zero();
      Vector3d min = Vector3d::Constant(1e9);
      Vector3d max = -min;
      for (const int i : labelled[k]) {
        mean += points[i].cast<double>() / cluster.points;
        min = min.cwiseMin(points[i].cast<double>());
        max = max.cwiseMax(points[i].cast<double>());
      }
      EXPECT_LT((cluster.centroid_S - mean).norm(), 1e-9);
      EXPECT_EQ(cluster.min_S, min);
      EXPECT_EQ(cluster.max_S, max);
      double variance = 0;
      for (const int i : labelled[k]) {
        variance += (points[i].cast<double>() - mean).squaredNorm() / cluster.points;
      }
      EXPECT_NEAR(cluster.spread_m.squaredNorm(), variance, 1e-9 * (1 + variance));
    }
  }

  std::unique_ptr<ClusterFinder> finder_ = std::make_unique<ClusterFinder>();
};

// Coordinates that invite trouble: whole numbers of half reaches, a float to either side, any.
rc::Gen<float> Awkward(int reaches) {
  const auto halves = rc::gen::inRange(-2 * reaches, 2 * reaches + 1);
  return rc::gen::oneOf(
      rc::gen::map(halves, [](int i) { return static_cast<float>(i) * 0.125F; }),
      rc::gen::map(halves,
                   [](int i) { return std::nextafter(static_cast<float>(i) * 0.125F, 9.0F); }),
      rc::gen::map(halves,
                   [](int i) { return std::nextafter(static_cast<float>(i) * 0.125F, -9.0F); }),
      rc::gen::map(rc::gen::inRange(-250000 * reaches, 250000 * reaches),
                   [](int i) { return static_cast<float>(i) * 1e-6F; }));
}

rc::Gen<Vector3f> AwkwardPoint(int reaches) {
  return rc::gen::map(rc::gen::tuple(Awkward(reaches), Awkward(reaches), Awkward(reaches)),
                      [](const std::tuple<float, float, float>& t) {
                        return Vector3f(std::get<0>(t), std::get<1>(t), std::get<2>(t));
                      });
}

TEST_F(ClusterFinderTest, FindsWhatFloodingOverAllPairsFinds) {
  EXPECT_TRUE(kSeeded);
  std::size_t most = 0;
  EXPECT_TRUE(rc::check("clusters of all pairs", [&] {
    const int reaches = *rc::gen::element(2, 4, 12);
    Points points = *rc::gen::container<Points>(AwkwardPoint(reaches));
    if (!points.empty()) {
      points.insert(points.end(), *rc::gen::inRange(0, 4), points.front());  // one, many times
    }
    const ClusterConfig config{.reach_m = 0.25,
                               .spacing_rad = *rc::gen::element(0.0, 0.0, 0.02, 0.15, 0.5),
                               .count_min = *rc::gen::inRange(1, 5)};
    RC_ASSERT(finder_->Find(points, config) == Status::kOk);
    const auto expected = OfAllPairs(points, config);
    RC_ASSERT(Labelled() == expected);
    most = std::max(most, expected.size());
    ExpectMeasuresOf(points);
  }));
  EXPECT_GT(most, 5U) << "the points were too few or too near each other to say anything";
}

TEST_F(ClusterFinderTest, JoinsAtTheReachAndNotBeyond) {
  const float beyond = std::nextafter(0.25F, 1.0F);
  const struct {
    const char* name;
    Vector3f from;
    Vector3f step;
    int clusters;
  } cases[] = {{"at the reach along x", {0.5F, 0, 0}, {0.25F, 0, 0}, 1},
               {"just beyond it", {0, 0, 0}, {beyond, 0, 0}, 2},
               {"backwards across zero", {0.125F, 0, 0}, {-0.25F, 0, 0}, 1},
               {"within it by a diagonal", {1, 1, 1}, {0, 0.15F, 0.19F}, 1},
               {"beyond it by a diagonal", {1, 1, 1}, {0.25F, 0.25F, 0}, 2},
               {"onto itself", {1, 2, 3}, {0, 0, 0}, 1},
               {"far out", {16383.75F, 0, -16384}, {0.25F, 0, 0}, 1}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const Points pair{c.from, c.from + c.step};
    ASSERT_EQ(finder_->Find(pair, {.reach_m = 0.25, .count_min = 1}), Status::kOk);
    EXPECT_EQ(finder_->clusters().size(), c.clusters);
  }
}

TEST_F(ClusterFinderTest, FindsNeighboursFarOutWhereFloatsAreCoarse) {
  Rng rng(6);
  for (const double out : {100.0, 3000.0, ClusterFinder::kFar_reaches * 0.25 - 3}) {
    Points points;
    for (int i = 0; i < 800; ++i) {
      points.push_back(Vector3d(out + rng.Uniform(0, 2), rng.Uniform(0, 2) - out, rng.Uniform(0, 2))
                           .cast<float>());
    }
    const ClusterConfig config{.reach_m = 0.25, .count_min = 2};
    ASSERT_EQ(finder_->Find(points, config), Status::kOk);
    EXPECT_EQ(Labelled(), OfAllPairs(points, config)) << out;
  }
}

TEST_F(ClusterFinderTest, LeavesOutAsNoiseWhatHasTooFewPoints) {
  const Points points{{0, 0, 0}, {0.1F, 0, 0}, {5, 0, 0}, {0.2F, 0, 0}, {5.1F, 0, 0}};
  ASSERT_EQ(finder_->Find(points, {.reach_m = 0.15, .count_min = 3}), Status::kOk);
  EXPECT_EQ(Labelled(), (std::vector<std::vector<int>>{{0, 1, 3}}));
  EXPECT_EQ(finder_->labels()[2], ClusterFinder::kNone);
  const PointCluster& rod = finder_->clusters()[0];
  EXPECT_NEAR(rod.spread_m.x(), std::sqrt(0.02 / 3), 1e-7);
  EXPECT_NEAR(rod.spread_m.tail<2>().norm(), 0, 1e-7);
  ASSERT_EQ(finder_->Find({}, {}), Status::kOk);
  EXPECT_TRUE(finder_->clusters().empty());
  EXPECT_TRUE(finder_->labels().empty());
}

/// A wall across the view, as a camera at the origin with this angle between pixels sees it.
Points WallOf(double z_m, double pixel_rad) {
  Points points;
  for (int v = -20; v <= 20; ++v) {
    for (int u = -20; u <= 20; ++u) {
      points.push_back(Vector3d(u * pixel_rad * z_m, v * pixel_rad * z_m, z_m).cast<float>());
    }
  }
  return points;
}

TEST_F(ClusterFinderTest, AReachThatGrowsWithRangeHoldsFarWallsTogetherAndNearOnesApart) {
  constexpr double kPixel_rad = 0.01;
  Points points = WallOf(6, kPixel_rad);  // 6 cm between its points
  for (const Vector3f& p : WallOf(1, kPixel_rad)) {
    points.push_back(p);
    points.emplace_back(p + Vector3f(0, 0, 0.05F));  // a second one 5 cm behind
  }
  const auto clusters = [&](double spacing_rad) {
    EXPECT_EQ(finder_->Find(points, {.reach_m = 0.02, .spacing_rad = spacing_rad}), Status::kOk);
    return finder_->clusters().size();
  };
  EXPECT_EQ(clusters(0), 2) << "the far wall's points are noise, each by itself";
  EXPECT_EQ(clusters(2 * kPixel_rad), 3);
  EXPECT_EQ(clusters(6 * kPixel_rad), 2) << "the near walls are one";
}

TEST_F(ClusterFinderTest, RefusesWhatIsNotFiniteOrTooFar) {
  const Points good(20, Vector3f(1, 2, 3));
  for (const float bad : {kNan, kInf, -kInf, 1e9F, std::nextafter(65536 * 0.25F, 1e9F)}) {
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(finder_->Find(good, {.reach_m = 0.25}), Status::kOk);
      EXPECT_EQ(finder_->clusters().size(), 1);
      Points points = good;
      points[19](axis) = bad;
      EXPECT_EQ(finder_->Find(points, {.reach_m = 0.25}), Status::kOutOfRange);
      EXPECT_TRUE(finder_->clusters().empty());
      EXPECT_TRUE(finder_->labels().empty());
    }
  }
}

TEST_F(ClusterFinderTest, SaysWhenThereAreTooManyPointsAndTakesTheFirst) {
  Points points(ClusterFinder::kMaxPoints, Vector3f(1, 2, 3));
  ASSERT_EQ(finder_->Find(points, {}), Status::kOk);
  points.insert(points.end(), 5, Vector3f(1, 2, 3));
  EXPECT_EQ(finder_->Find(points, {}), Status::kFull);
  EXPECT_EQ(finder_->points_refused(), 5);
  ASSERT_EQ(finder_->clusters().size(), 1);
  EXPECT_EQ(finder_->clusters()[0].points, ClusterFinder::kMaxPoints);
  EXPECT_EQ(finder_->Find({points.data(), 20}, {}), Status::kOk);
  EXPECT_EQ(finder_->points_refused(), 0);
}

TEST_F(ClusterFinderTest, SaysWhenThereAreTooManyClustersAndKeepsTheLargest) {
  constexpr int kClusters = ClusterFinder::kMaxClusters + 7;
  Points points;
  for (int k = 0; k < kClusters; ++k) {
    points.insert(points.end(), k < 7 ? 2 : 3, Vector3f(static_cast<float>(k), 0, 0));
  }
  EXPECT_EQ(finder_->Find(points, {.count_min = 2}), Status::kFull);
  EXPECT_EQ(finder_->clusters_refused(), 7);
  ASSERT_EQ(finder_->clusters().size(), ClusterFinder::kMaxClusters);
  for (int k = 0; k < ClusterFinder::kMaxClusters; ++k) {
    EXPECT_EQ(finder_->clusters()[k].points, 3);
    EXPECT_EQ(finder_->clusters()[k].first, 14 + 3 * k);
  }
  EXPECT_EQ(finder_->labels()[0], ClusterFinder::kNone);
  EXPECT_EQ(finder_->Find({points.data(), 100}, {.count_min = 2}), Status::kOk);
  EXPECT_EQ(finder_->clusters_refused(), 0);
}

TEST_F(ClusterFinderTest, DoesNotDependOnThePointsOrder) {
  Rng rng(8);
  Points points;
  for (int i = 0; i < 3000; ++i) {
    points.push_back(
        Vector3d(rng.Uniform(-3, 3), rng.Uniform(-3, 3), rng.Uniform(0, 3)).cast<float>());
  }
  const ClusterConfig config{.reach_m = 0.15, .spacing_rad = 0.06, .count_min = 3};
  const auto boxes = [&] {
    std::multiset<std::tuple<int, double, double, double, double>> all;
    for (const PointCluster& c : finder_->clusters()) {
      all.emplace(c.points, c.min_S.x(), c.max_S.y(), c.min_S.z(), c.max_S.z());
    }
    return all;
  };
  ASSERT_EQ(finder_->Find(points, config), Status::kOk);
  const auto before = boxes();
  const Points in_order = points;
  const std::vector<int> labels(finder_->labels().begin(), finder_->labels().end());
  EXPECT_GT(before.size(), 20U);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::vector<int> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::minstd_rand(seed));
    for (std::size_t i = 0; i < order.size(); ++i) {
      points[i] = in_order[order[i]];
    }
    ASSERT_EQ(finder_->Find(points, config), Status::kOk);
    EXPECT_EQ(boxes(), before);
    // Which points are noise, point by point.
    for (std::size_t i = 0; i < order.size(); ++i) {
      EXPECT_EQ(finder_->labels()[i] == ClusterFinder::kNone,
                labels[order[i]] == ClusterFinder::kNone);
    }
  }
}

TEST_F(ClusterFinderTest, TakesNothingFromTheHeap) {
  Rng rng(9);
  Points points;
  for (int i = 0; i < 20000; ++i) {
    points.push_back(Vector3d(rng.Normal(), rng.Normal(), 5 + rng.Normal()).cast<float>());
  }
  const test::NoAllocScope no_heap;
  EXPECT_EQ(finder_->Find(points, {.spacing_rad = 0.03, .count_min = 5}), Status::kOk);
  EXPECT_GT(finder_->clusters().size(), 1);
}

}  // namespace
}  // namespace pipewright
