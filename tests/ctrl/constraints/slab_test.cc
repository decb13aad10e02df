// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "ctrl/constraints/constraint_set.h"
#include "platform/robot/state_history.h"
#include "tests/ctrl/constraints/random_world.h"

namespace pipewright {
namespace {

using test::MakePlane;
using test::RandomDirection;
using test::RandomIn;

const Vector3d kLo{-1, -1, -1};
const Vector3d kHi{1, 1, 1};
constexpr double kInflation_m = 0.05;
constexpr double kBehind_m = 0.15;

SlabDistance To(const PlaneEstimate& plane, const Vector3d& t) {
  return PointToSlab(t, plane, kInflation_m, kBehind_m);
}

PlaneEstimate SmallPlane(Rng& rng) {
  PlaneEstimate plane =
      MakePlane(1, RandomIn(rng, 0.3 * kLo, 0.3 * kHi), RandomDirection(rng), 0, 0.03, 0.01);
  for (int i = 0; i < 2; ++i) {
    plane.extent_lo_m[i] = -rng.Uniform(0, 0.5);
    plane.extent_hi_m[i] = rng.Uniform(0, 0.5);
  }
  return plane;
}

/// A point of the slab, at shares of its edges.
Vector3d InSlab(const PlaneEstimate& plane, const Vector3d& share) {
  const auto along = [&](int i) {
    const double lo = plane.extent_lo_m[i] - kInflation_m;
    return lo + share(i) * (plane.extent_hi_m[i] + kInflation_m - lo);
  };
  return plane.p_WCentroid + along(0) * plane.e1_W + along(1) * plane.e2_W -
         share.z() * kBehind_m * plane.n_W;
}

bool Inside(const PlaneEstimate& plane, const Vector3d& t, double tolerance_m) {
  const Vector3d w = t - plane.p_WCentroid;
  const double a = plane.e1_W.dot(w);
  const double b = plane.e2_W.dot(w);
  const double h = plane.n_W.dot(w);
  const double rim = kInflation_m + tolerance_m;
  return a >= plane.extent_lo_m[0] - rim && a <= plane.extent_hi_m[0] + rim &&
         b >= plane.extent_lo_m[1] - rim && b <= plane.extent_hi_m[1] + rim && h <= tolerance_m &&
         h >= -kBehind_m - tolerance_m;
}

/// No point of the slab is nearer, and the point that far against the gradient is one of it.
TEST(PointToSlab, IsTheLeastDistance) {
  for (int i = 0; i < 1000; ++i) {
    SCOPED_TRACE(i);
    Rng rng(1, i);
    const PlaneEstimate plane = SmallPlane(rng);
    const Vector3d t = RandomIn(rng, kLo, kHi);
    const SlabDistance distance = To(plane, t);
    EXPECT_NEAR(distance.gradient_W.norm(), 1, 1e-12);
    EXPECT_EQ(distance.d_m < 0, Inside(plane, t, 0));
    if (distance.d_m < 0) {
      continue;
    }
    EXPECT_TRUE(Inside(plane, t - distance.d_m * distance.gradient_W, 1e-12));
    for (int k = 0; k < 100; ++k) {
      EXPECT_LE(distance.d_m,
                (t - InSlab(plane, RandomIn(rng, Vector3d::Zero(), kHi))).norm() + 1e-12);
    }
  }
}

/// Inside, a way against −d out of the face or a side that is nearest, and never out of the back.
TEST(PointToSlab, LeadsOutOfTheNearestSideButNotThrough) {
  int sides = 0;
  for (int i = 0; i < 1000; ++i) {
    SCOPED_TRACE(i);
    Rng rng(2, i);
    const PlaneEstimate plane = SmallPlane(rng);
    const Vector3d t = InSlab(plane, RandomIn(rng, Vector3d::Constant(1e-3), 0.999 * kHi));
    const SlabDistance distance = To(plane, t);
    ASSERT_LT(distance.d_m, 0);
    EXPECT_TRUE(Inside(plane, t + 0.999 * -distance.d_m * distance.gradient_W, 0));
    EXPECT_FALSE(Inside(plane, t + 1.001 * -distance.d_m * distance.gradient_W, 0));
    EXPECT_GE(distance.gradient_W.dot(plane.n_W), -1e-12);
    sides += distance.on_face() ? 0 : 1;
  }
  EXPECT_GT(sides, 50);
}

TEST(PointToSlab, HasNoJumpOnAnyWayRoundIt) {
  constexpr int kSteps = 2000;
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    Rng rng(3, i);
    const PlaneEstimate plane = SmallPlane(rng);
    const Vector3d from = RandomIn(rng, kLo, kHi);
    const Vector3d to = RandomIn(rng, kLo, kHi);
    const double step = (to - from).norm() / kSteps;
    SlabDistance last = To(plane, from);
    for (int k = 1; k <= kSteps; ++k) {
      const SlabDistance now = To(plane, from + (to - from) * k / kSteps);
      const double nearer = std::min(now.d_m, last.d_m);
      if (nearer < 0.01) {
        last = now;
        continue;  // in it: kinks, and the back that is not left by
      }
      EXPECT_LE(std::abs(now.d_m - last.d_m), step + 1e-12);
      EXPECT_LE((now.gradient_W - last.gradient_W).norm(), 1.05 * step / nearer + 1e-12);
      last = now;
    }
  }
}

/// The rule that the rows state, -g'v <= eta (d - d_safe), on a point that is driven round the end
/// of a wall, into it and along it: it is never held to a rate that is negative, as it would be
/// where a plane begins to act at a distance that is too small already.
TEST(PointToSlab, ItsRateBoundLetsAPointRoundTheEndAndNeverThrough) {
  constexpr double kSafe_m = 0.1;
  constexpr double kEta_1ps = 1;
  constexpr double kPeriod_s = 0.01;
  int close = 0;
  int behind = 0;
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(i);
    Rng rng(4, i);
    const PlaneEstimate plane = SmallPlane(rng);
    Vector3d t = plane.p_WCentroid + (plane.extent_hi_m[0] + 0.3) * plane.e1_W +
                 rng.Uniform(0, 0.3) * plane.n_W;
    const Vector3d goal = InSlab(plane, {rng.Uniform(0.5, 1), 0.5, rng.Uniform(0, 4)});
    for (int k = 0; k < 1200; ++k) {
      Vector3d v = 2 * (goal - t) + 0.1 * RandomDirection(rng);
      v *= std::min(1.0, 0.5 / v.norm());
      const SlabDistance d = To(plane, t);
      const double limit = -kEta_1ps * (d.d_m - kSafe_m);
      ASSERT_LE(limit, 1e-9);  // standing still keeps it
      v += std::max(0.0, limit - d.gradient_W.dot(v)) * d.gradient_W;
      const double h_before = plane.n_W.dot(t) - plane.d_m;
      t += kPeriod_s * v;
      ASSERT_FALSE(Inside(plane, t, kSafe_m * 0.5));
      close += d.d_m < 1.05 * kSafe_m ? 1 : 0;
      behind += h_before >= -kBehind_m && plane.n_W.dot(t) - plane.d_m < -kBehind_m ? 1 : 0;
    }
  }
  EXPECT_GT(close, 10000);
  EXPECT_GT(behind, 20);  // ways round the end were taken
}

/// The plane with (n, d) changed by x of the tangent: the rectangle moves along as one body.
PlaneEstimate Moved(const PlaneEstimate& plane, const Vec<4>& change) {
  PlaneEstimate moved = plane;
  moved.n_W = (plane.n_W + change.head<3>()).normalized();
  moved.d_m = plane.d_m + change(3);
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(plane.n_W, moved.n_W);
  moved.e1_W = turn * plane.e1_W;
  moved.e2_W = turn * plane.e2_W;
  moved.p_WCentroid += (moved.d_m - moved.n_W.dot(plane.p_WCentroid)) * moved.n_W;
  return moved;
}

double F(const PlaneEstimate& plane, const Vector3d& t, const Vector3d& v, double eta) {
  const SlabDistance d = To(plane, t);
  return d.gradient_W.dot(v) + eta * d.d_m;
}

/// (n, d)'s free directions, as MakePlane's covariance has them: Σ = G diag(s²) G'.
Mat<4, 3> Free(const PlaneEstimate& plane) {
  Mat<4, 3> G = Mat<4, 3>::Zero();
  G.block<3, 1>(0, 0) = plane.e1_W;
  G.block<3, 1>(0, 1) = plane.e2_W;
  G.row(3) << plane.e1_W.dot(plane.p_WCentroid), plane.e2_W.dot(plane.p_WCentroid), 1;
  return G;
}

VelocityCone ConeOf(const PlaneEstimate& plane, const Vector3d& t, double eta) {
  const SlabDistance d = To(plane, t);
  return SlabCone(plane, t, d.gradient_W, SlabCurvature(plane, d), eta);
}

TEST(SlabCone, IsTheFirstOrderDeviationByFiniteDifferences) {
  int features[4] = {};  // by how many of the direction's components are not zero
  for (int i = 0; i < 600; ++i) {
    SCOPED_TRACE(i);
    Rng rng(5, i);
    const PlaneEstimate plane = SmallPlane(rng);
    const Vector3d t = RandomIn(rng, kLo, kHi);
    const Vector3d v = RandomIn(rng, kLo, kHi);
    const double eta = rng.Uniform(0.1, 5);
    const SlabDistance d = To(plane, t);
    if (d.d_m < 0.02) {
      continue;
    }
    ++features[(d.away_P.array() != 0).count()];
    const Mat<4, 3> G = Free(plane);
    const Vector3d sigma{0.03, 0.03, 0.01};
    double variance = 0;
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vec<4> step = kStep * G.col(k);
      const double slope =
          (F(Moved(plane, step), t, v, eta) - F(Moved(plane, -step), t, v, eta)) / (2 * kStep);
      variance += std::pow(slope * sigma(k), 2);
    }
    EXPECT_NEAR(ConeOf(plane, t, eta).Sigma(v), std::sqrt(variance), 1e-7);
  }
  EXPECT_GT(features[1], 50);  // faces, edges and corners
  EXPECT_GT(features[2], 50);
  EXPECT_GT(features[3], 50);
}

TEST(SlabCone, OnTheFaceIsThePlanes) {
  for (int i = 0; i < 300; ++i) {
    Rng rng(6, i);
    const PlaneEstimate plane = SmallPlane(rng);
    const Vector3d t = InSlab(plane, {0.5, 0.5, -rng.Uniform(0, 3)});
    const Vector3d v = RandomIn(rng, kLo, kHi);
    ASSERT_TRUE(To(plane, t).on_face());
    EXPECT_NEAR(ConeOf(plane, t, 1.5).Sigma(v), PlaneCone(plane, t, 1.5).Sigma(v), 1e-9);
  }
}

/// Planes drawn about the estimate, each distance and direction anew: the row that is active holds
/// with its probability, at borders and corners too.
TEST(SlabCone, TheTruePlaneKeepsTheDistanceWithTheStatedProbability) {
  constexpr int kPairs = 60;
  constexpr int kDraws = 3000;
  constexpr double kAlpha = 0.95;
  constexpr double kFirstOrder = 0.005;  // what the curvature of θ -> f may take
  const double z = *ChanceQuantile(kAlpha);
  int held = 0;
  int held_without = 0;
  int borders = 0;
  for (int i = 0; i < kPairs; ++i) {
    Rng rng(7, i);
    const PlaneEstimate plane = SmallPlane(rng);
    Vector3d t;
    do {
      t = RandomIn(rng, kLo, kHi);
    } while (To(plane, t).d_m < 0.2 || (i % 3 > 0 && To(plane, t).on_face()));
    borders += To(plane, t).on_face() ? 0 : 1;
    const Vector3d v = RandomIn(rng, 0.5 * kLo, 0.5 * kHi);
    const Mat<4, 3> G = Free(plane);
    const Vector3d sigma{0.01, 0.01, 0.005};
    PlaneEstimate known = plane;
    known.covariance = G * sigma.cwiseAbs2().asDiagonal() * G.transpose();
    const double mean = F(plane, t, v, 1);
    const double bound = mean - z * ConeOf(known, t, 1).Sigma(v);
    for (int k = 0; k < kDraws; ++k) {
      const Vector3d x = sigma.cwiseProduct(Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
      const double f = F(Moved(plane, G * x), t, v, 1);
      held += f >= bound ? 1 : 0;
      held_without += f >= mean ? 1 : 0;
    }
  }
  EXPECT_GT(borders, 30);
  constexpr double kAll = kPairs * kDraws;
  const double least = kAlpha - kFirstOrder - 2.326 * std::sqrt(kAlpha * (1 - kAlpha) / kAll);
  EXPECT_GE(held / kAll, least);
  EXPECT_LT(held_without / kAll, 0.6);  // the test can tell
}

/// The base driven towards a wall's end from its side, before the wall, level with it and behind:
/// what its row leaves it changes no faster than the base moves, from where there is no row on.
TEST(ConstraintBuilder, BesideTheEndOfAWallNoRowBeginsWhereItsDistanceIsLost) {
  const test::VoxelWorld world;
  const ConstraintConfig config;
  const ConstraintBuilder builder(config, TracerUf7(), TracerUf7Shapes());
  Scene scene;
  ASSERT_TRUE(scene.planes.push_back(MakePlane(1, {2, 0, 0.5}, {-1, 0, 0}, 0.5, 0, 0)));
  constexpr double kStep_m = 0.02;
  const double without_mps = config.eta_1ps * config.consider_m;
  double least = without_mps;
  for (double x = 1; x < 3.5; x += 0.05) {
    double last = without_mps;
    for (double y = 2.5; y > 0.52 + config.plane_inflation_m; y -= kStep_m) {
      Configuration q = test::HomeConfiguration();
      q(0) = x;
      q(1) = y;
      static ConstraintSet set;
      builder.Build(q, {TracerUf7(), q}, Controls::Zero(), scene, world.field(), set);
      double now = without_mps;
      for (const ChanceRow& row : set.chance) {
        now = row.key >> 26 == static_cast<int>(RowKind::kBasePlane) ? row.b : now;
      }
      EXPECT_LE(std::abs(now - last), config.eta_1ps * kStep_m + 1e-12) << x << ", " << y;
      last = now;
      least = std::min(least, now);
    }
  }
  EXPECT_LT(least, 0);  // it came near
}

}  // namespace
}  // namespace pipewright
