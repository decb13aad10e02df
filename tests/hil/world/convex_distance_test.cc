// SPDX-License-Identifier: MIT
#include "hil/world/convex_distance.h"

#include <ccd/ccd.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

constexpr double kPi = std::numbers::pi;

Isometry3d At(const Vector3d& p, const Vector3d& axis = Vector3d::UnitZ(), double angle = 0) {
  return Eigen::Translation3d(p) * Eigen::AngleAxisd(angle, axis.normalized());
}

struct Case {
  const char* name;
  Shape a;
  Isometry3d X_WA;
  Shape b;
  Isometry3d X_WB;
  double distance_m;
};

const Case kCases[] = {
    {"spheres apart", Shape::Sphere(0.2), At({0, 0, 0}), Shape::Sphere(0.3), At({0, 3, 4}), 4.5},
    {"spheres that overlap", Shape::Sphere(1), At({0, 0, 0}), Shape::Sphere(1), At({0, 0, 0.5}), 0},
    {"boxes face to face", Shape::Box({1, 2, 3}), At({0, 0, 0}), Shape::Box({1, 1, 1}),
     At({1.25, 0.1, 0.7}), 0.25},
    {"boxes corner to corner", Shape::Box({2, 2, 2}), At({0, 0, 0}), Shape::Box({2, 2, 2}),
     At({3, 4, 2.5}), std::sqrt(1 + 4 + 0.25)},
    {"boxes with parallel edges", Shape::Box({2, 2, 2}), At({0, 0, 0}), Shape::Box({2, 2, 2}),
     At({1 + 1 + std::numbers::sqrt2, 0, 0}, Vector3d::UnitZ(), kPi / 4), 1},
    {"crossed cylinders", Shape::Cylinder(0.1, 2), At({0, 0, 0}), Shape::Cylinder(0.2, 2),
     At({0.5, 0, 0}, Vector3d::UnitX(), kPi / 2), 0.2},
    {"parallel cylinders", Shape::Cylinder(0.1, 2), At({0, 0, 0}), Shape::Cylinder(0.2, 1),
     At({0.3, 0.4, 0.2}), 0.2},
    {"cylinder over cylinder, caps facing", Shape::Cylinder(0.5, 1), At({0, 0, 0}),
     Shape::Cylinder(0.1, 1), At({0.3, 0.1, 1.75}), 0.75},
    {"rim to rim", Shape::Cylinder(1, 2), At({0, 0, 0}), Shape::Cylinder(1, 2), At({5, 0, 6}), 5},
    {"sphere beside a rim", Shape::Cylinder(1, 2), At({0, 0, 0}), Shape::Sphere(0.5), At({4, 0, 5}),
     4.5},
    {"the same place", Shape::Box({1, 1, 1}), At({1, 1, 1}), Shape::Cylinder(0.1, 0.1),
     At({1, 1, 1}), 0},
    {"a triangle under a sphere", Shape::Triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), At({0, 0, 0}),
     Shape::Sphere(0.1), At({0.2, 0.2, 0.6}), 0.5},
};

TEST(ConvexDistance, IsTheDistanceKnownFromGeometry) {
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.name);
    EXPECT_NEAR(ConvexDistance(c.a, c.X_WA, c.b, c.X_WB), c.distance_m, 2e-8);
    EXPECT_NEAR(ConvexDistance(c.b, c.X_WB, c.a, c.X_WA), c.distance_m, 2e-8);
  }
}

/// A shape grown by a sphere, for libccd.
struct Grown {
  const Shape* shape;
  Isometry3d X_WG;
  double by_m;
};

void SupportOf(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const auto* grown = static_cast<const Grown*>(object);
  const Vector3d d_W(direction->v[0], direction->v[1], direction->v[2]);
  const Vector3d p_W =
      grown->X_WG * Support(*grown->shape, grown->X_WG.linear().transpose() * d_W) +
      d_W.normalized() * grown->by_m;
  ccdVec3Set(point, p_W.x(), p_W.y(), p_W.z());
}

void CenterOf(const void* object, ccd_vec3_t* point) {
  const auto* grown = static_cast<const Grown*>(object);
  const Shape& s = *grown->shape;
  const Vector3d p_W = grown->X_WG * ((s.corners_G[0] + s.corners_G[1] + s.corners_G[2]) / 3);
  ccdVec3Set(point, p_W.x(), p_W.y(), p_W.z());
}

bool Intersect(const Grown& a, const Grown& b) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = SupportOf;
  ccd.support2 = SupportOf;
  ccd.center1 = CenterOf;
  ccd.center2 = CenterOf;
  ccd.max_iterations = 1000;
  ccd.mpr_tolerance = 1e-9;
  return ccdMPRIntersect(&a, &b, &ccd) == 1;
}

Shape RandomShape(Rng& rng) {
  switch (rng.Index(4)) {
    case 0:
      return Shape::Box({rng.Uniform(0.01, 1), rng.Uniform(0.01, 1), rng.Uniform(0.01, 1)});
    case 1:
      return Shape::Cylinder(rng.Uniform(0.01, 0.5), rng.Uniform(0.01, 2));
    case 2:
      return Shape::Sphere(rng.Uniform(0.01, 0.5));
    default:
      return Shape::Triangle(Vector3d(rng.Normal(), rng.Normal(), rng.Normal()),
                             Vector3d(rng.Normal(), rng.Normal(), rng.Normal()),
                             Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
  }
}

Isometry3d RandomPose(Rng& rng, double spread_m) {
  const Vector3d p(rng.Normal(), rng.Normal(), rng.Normal());
  return At(p * spread_m, {rng.Normal(), rng.Normal(), rng.Normal()}, rng.Uniform(-kPi, kPi));
}

// Oracle: libccd's intersection test (MPR; its GJK misses shallow overlaps of round shapes) on
// shapes grown by a little less and a little more than the distance.
TEST(ConvexDistance, AgreesWithIntersectionOfGrownShapes) {
  Rng rng(11);
  int apart = 0;
  for (int i = 0; i < 10000; ++i) {
    SCOPED_TRACE(i);
    const Shape a = RandomShape(rng);
    const Shape b = RandomShape(rng);
    const Isometry3d X_WA = RandomPose(rng, 0.7);
    const Isometry3d X_WB = RandomPose(rng, 0.7);
    const double distance = ConvexDistance(a, X_WA, b, X_WB);
    ASSERT_NEAR(distance, ConvexDistance(b, X_WB, a, X_WA), 3e-8);
    constexpr double kMargin_m = 1e-5;
    if (distance > kMargin_m) {
      ++apart;
      ASSERT_FALSE(Intersect({&a, X_WA, distance - kMargin_m}, {&b, X_WB, 0}));
    }
    ASSERT_TRUE(Intersect({&a, X_WA, distance + kMargin_m}, {&b, X_WB, 0}));
  }
  EXPECT_GT(apart, 2500);
  EXPECT_LT(apart, 9500);
}

TEST(ConvexDistance, ThatIsStoppedEarlyIsALowerBoundAboveTheLimit) {
  Rng rng(12);
  for (int i = 0; i < 2000; ++i) {
    const Shape a = RandomShape(rng);
    const Shape b = RandomShape(rng);
    const Isometry3d X_WA = RandomPose(rng, 1);
    const Isometry3d X_WB = RandomPose(rng, 1);
    const double exact = ConvexDistance(a, X_WA, b, X_WB);
    const double limit = rng.Uniform(0, 1);
    const double stopped = ConvexDistance(a, X_WA, b, X_WB, limit);
    if (exact <= limit) {
      EXPECT_NEAR(stopped, exact, 2e-8);
    } else {
      EXPECT_GT(stopped, limit - 2e-8);
      EXPECT_LE(stopped, exact + 2e-8);
    }
  }
}

TEST(Shape, SignedDistanceOfAPointIsItsDistanceAsASphereOfNoSize) {
  Rng rng(13);
  for (int i = 0; i < 5000; ++i) {
    const Shape shape = i % 2 == 0 ? Shape::Box({0.3, 0.5, 0.9}) : Shape::Cylinder(0.3, 0.8);
    const Vector3d p(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1));
    const double distance = ConvexDistance(shape, Isometry3d::Identity(), Shape::Sphere(0), At(p));
    EXPECT_NEAR(std::max(SignedDistance(shape, p), 0.0), distance, 2e-8);
  }
}

TEST(Shape, SignedDistanceInsideIsToTheNearestFace) {
  EXPECT_DOUBLE_EQ(SignedDistance(Shape::Box({2, 4, 6}), {0.9, 0, 0}), -0.1);
  EXPECT_DOUBLE_EQ(SignedDistance(Shape::Cylinder(1, 4), {0, 0.75, 0}), -0.25);
  EXPECT_NEAR(SignedDistance(Shape::Cylinder(1, 4), {0, 0.1, -1.9}), -0.1, 1e-15);
  EXPECT_DOUBLE_EQ(SignedDistance(Shape::Sphere(1), {0, 0.25, 0}), -0.75);
}

TEST(Shape, NoSupportPointIsOutsideTheBoundingSphereAndOneTouchesIt) {
  Rng rng(14);
  for (int i = 0; i < 50; ++i) {
    const Shape shape = RandomShape(rng);
    double farthest = 0;
    for (int k = 0; k < 5000; ++k) {
      const Vector3d p = Support(shape, {rng.Normal(), rng.Normal(), rng.Normal()});
      farthest = std::max(farthest, p.norm());
    }
    EXPECT_NEAR(farthest, BoundingRadius(shape), 1e-9);
  }
}

}  // namespace
}  // namespace pipewright::hil
