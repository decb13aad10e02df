// SPDX-License-Identifier: MIT
#include "platform/robot/shapes.h"

#include <ccd/ccd.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "hil/plant/robot_description.h"
#include "platform/core/rng.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/robot.h"
#include "platform/robot/uf7.h"

namespace pipewright {
namespace {

using Shape = hil::CollisionShape;

constexpr double kCover_m = 0.005;  // what the header promises

/// A link of the plant as one of our bodies, and its frame there (the arm's foot is in the base).
struct BodyFrame {
  int body = -1;
  Isometry3d X_LLink = Isometry3d::Identity();
};

BodyFrame BodyOf(const std::string& link) {
  BodyFrame frame;
  if (link == "base_link" || link == "arm_base") {
    frame.body = 0;
    if (link == "arm_base") {
      frame.X_LLink.translation() = Vector3d(TracerUf7().mount.p_BA_m.data());
    }
  } else if (link == "tool") {
    frame.body = Kinematics<7>::kTool;
  } else {
    frame.body = link.back() - '0';
  }
  return frame;
}

/// Points of the surface of a plant shape, in its own frame, about every 8 mm.
std::vector<Vector3d> SurfaceOf(const Shape& shape) {
  constexpr int kSteps = 24;
  std::vector<Vector3d> points;
  for (int i = 0; i <= kSteps; ++i) {
    const double a = 2.0 * i / kSteps - 1;
    for (int j = 0; j <= kSteps; ++j) {
      const double b = 2.0 * j / kSteps - 1;
      if (shape.kind == Shape::Kind::kBox) {
        for (const double c : {-1.0, 1.0}) {
          for (const Vector3d& p : {Vector3d{a, b, c}, Vector3d{a, c, b}, Vector3d{c, a, b}}) {
            points.push_back(p.cwiseProduct(shape.size_m / 2));
          }
        }
      } else {
        const double r = shape.size_m.x();
        const double half = shape.size_m.z() / 2;
        const Vector3d rim{r * std::cos(std::numbers::pi * a), r * std::sin(std::numbers::pi * a),
                           0};
        points.push_back(rim + Vector3d{0, 0, half * b});
        points.push_back((b + 1) / 2 * rim + Vector3d{0, 0, half});
        points.push_back((b + 1) / 2 * rim - Vector3d{0, 0, half});
      }
    }
  }
  return points;
}

double DistanceToSpheres(int body, const Vector3d& p_L) {
  double least = 1e9;
  for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
    if (sphere.body == body) {
      least = std::min(least, (p_L - sphere.p_L).norm() - sphere.r_m);
    }
  }
  return least;
}

double DistanceToCapsules(int body, const Vector3d& p_L) {
  double least = 1e9;
  for (const BodyCapsule& c : TracerUf7Shapes().capsules) {
    if (c.body == body) {
      const Vector3d d = c.p_LB - c.p_LA;
      const double t =
          d.norm() > 0 ? std::clamp((p_L - c.p_LA).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
      least = std::min(least, (p_L - c.p_LA - t * d).norm() - c.r_m);
    }
  }
  return least;
}

double DistanceToShapes(int body, const Vector3d& p_L) {
  double least = 1e9;
  for (const BodyShape& shape : TracerUf7Shapes().shapes) {
    if (shape.body == body) {
      const Vector3d p_G = shape.X_LG.inverse() * p_L;
      Vector3d beyond = p_G.cwiseAbs() - shape.half_m;
      if (shape.kind == BodyShape::Kind::kCylinder) {
        beyond = {p_G.head<2>().norm() - shape.half_m.x(), beyond.z(), -1};
      }
      least = std::min(least, beyond.cwiseMax(0).norm());
    }
  }
  return least;
}

template <typename Check>
void ForEachPlantPoint(const Check& check) {
  for (const Shape& shape : hil::TracerUf7Description().shapes) {
    SCOPED_TRACE(shape.link + " " + shape.name);
    ASSERT_NE(shape.kind, Shape::Kind::kMesh);
    const BodyFrame frame = BodyOf(shape.link);
    double worst = -1e9;
    Vector3d where = Vector3d::Zero();
    for (const Vector3d& p_G : SurfaceOf(shape)) {
      const Vector3d p_L = frame.X_LLink * (shape.X_LG * p_G);
      const double distance = check(frame.body, p_L);
      if (distance > worst) {
        worst = distance;
        where = p_L;
      }
    }
    EXPECT_LT(worst, kCover_m) << "at " << where.transpose();
  }
}

bool IsChassis(int body, const Vector3d& p_L) {
  return body == 0 && p_L.z() < TracerUf7().mount.p_BA_m[2] + 1e-9;
}

TEST(Shapes, SpheresCoverTheArmAndToolOfThePlant) {
  ForEachPlantPoint([](int body, const Vector3d& p_L) {
    return IsChassis(body, p_L) ? -1.0 : DistanceToSpheres(body, p_L);
  });
}

TEST(Shapes, CapsulesCoverTheArmAndToolOfThePlant) {
  ForEachPlantPoint([](int body, const Vector3d& p_L) {
    return IsChassis(body, p_L) ? -1.0 : DistanceToCapsules(body, p_L);
  });
}

TEST(Shapes, ExactShapesCoverThePlant) { ForEachPlantPoint(DistanceToShapes); }

TEST(Shapes, DiscsCoverThePlantsChassisSeenFromAbove) {
  const RobotShapes& robot = TracerUf7Shapes();
  ForEachPlantPoint([&](int body, const Vector3d& p_L) {
    if (!IsChassis(body, p_L)) {
      return -1.0;
    }
    EXPECT_GE(p_L.z(), robot.discs_z_lo_m - 1e-9);
    EXPECT_LE(p_L.z(), robot.discs_z_hi_m + 1e-9);
    double least = 1e9;
    for (const BaseDisc& disc : robot.discs) {
      least = std::min(least, (p_L.head<2>() - disc.p_B).norm() - disc.r_m);
    }
    return least;
  });
}

TEST(Shapes, SpheresAreTightEnoughToWorkNearPipes) {
  for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
    EXPECT_LE(sphere.r_m, 0.075);
    EXPECT_LT(DistanceToShapes(sphere.body, sphere.p_L), 1e-9) << "the centre is in the body";
  }
}

struct Posed {
  const BodyShape* shape;
  Isometry3d X_WG;
};

void Support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* support) {
  const Posed& posed = *static_cast<const Posed*>(object);
  const Vector3d d_G = posed.X_WG.linear().transpose() * Vector3d(direction->v);
  const Vector3d& half = posed.shape->half_m;
  Vector3d p_G{std::copysign(half.x(), d_G.x()), std::copysign(half.y(), d_G.y()),
               std::copysign(half.z(), d_G.z())};
  if (posed.shape->kind == BodyShape::Kind::kCylinder) {
    const double n = d_G.head<2>().norm();
    p_G.head<2>() = n > 0 ? Eigen::Vector2d(half.x() / n * d_G.head<2>()) : Eigen::Vector2d::Zero();
  }
  Eigen::Map<Vector3d>(support->v) = posed.X_WG * p_G;
}

void Center(const void* object, ccd_vec3_t* center) {
  Eigen::Map<Vector3d>(center->v) = static_cast<const Posed*>(object)->X_WG.translation();
}

bool Listed(int a, int b) {
  for (const IndexPair& pair : TracerUf7Shapes().shape_pairs) {
    if ((pair.first == a && pair.second == b) || (pair.first == b && pair.second == a)) {
      return true;
    }
  }
  return false;
}

TEST(Shapes, BodiesThatAreNotComparedNeverTouchWithinTheLimits) {
  const RobotShapes& robot = TracerUf7Shapes();
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = Support;
  ccd.center1 = ccd.center2 = Center;
  ccd.max_iterations = 100;
  Rng rng(31);
  for (int trial = 0; trial < 2000; ++trial) {
    Configuration q = Configuration::Zero();
    for (int i = 0; i < kArmJoints; ++i) {
      q(3 + i) = rng.Uniform(kUf7.joints[i].q_min_rad, kUf7.joints[i].q_max_rad);
    }
    const Kinematics<7> body(TracerUf7(), q);
    std::vector<Posed> posed;
    for (const BodyShape& shape : robot.shapes) {
      posed.push_back({&shape, body.X_WL(shape.body) * shape.X_LG});
    }
    for (int i = 0; i < robot.shapes.size(); ++i) {
      for (int j = 0; j < i; ++j) {
        const int a = std::min(robot.shapes[i].body, robot.shapes[j].body);
        const int b = std::max(robot.shapes[i].body, robot.shapes[j].body);
        const bool neighbours = b - a < 2;
        if (!neighbours && !Listed(i, j)) {
          EXPECT_EQ(ccdMPRIntersect(&posed[i], &posed[j], &ccd), 0) << a << " meets " << b;
        }
      }
    }
  }
}

TEST(Shapes, TheHomePostureStaysOverTheBase) {
  Configuration q = Configuration::Zero();
  q.tail<kArmJoints>() = HomeJoints(TracerUf7());
  const Kinematics<7> body(TracerUf7(), q);
  for (const BodySphere& sphere : TracerUf7Shapes().spheres) {
    const Vector3d p_W = body.Point(sphere.body, sphere.p_L);
    EXPECT_LT(p_W.x() + sphere.r_m, TracerUf7().base.length_m / 2 + 0.35);
    EXPECT_GT(p_W.x() - sphere.r_m, -TracerUf7().base.length_m / 2);
    EXPECT_LT(std::abs(p_W.y()) + sphere.r_m, TracerUf7().base.width_m / 2);
  }
  EXPECT_GT(body.z_WS().x(), 0.9);  // looks ahead
  EXPECT_GT(body.z_WS().z(), 0);    // and a little up
}

}  // namespace
}  // namespace pipewright
