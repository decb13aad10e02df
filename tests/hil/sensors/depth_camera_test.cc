// SPDX-License-Identifier: MIT
#include "hil/sensors/depth_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "hil/plant/robot_description.h"

namespace pipewright::hil {
namespace {

Solid Wall(double z_m) {
  Solid wall;  // a plane facing the origin from z
  wall.kind = SolidKind::kPlane;
  wall.X_WG =
      Eigen::Translation3d(0, 0, z_m) * Eigen::AngleAxisd(3.141592653589793, Vector3d::UnitX());
  return wall;
}

const RobotBodies kNoRobot{};

std::unique_ptr<DepthFrame> Shoot(DepthCamera& camera) {
  auto frame = std::make_unique<DepthFrame>();
  camera.Render(Isometry3d::Identity(), {}, *frame);
  return frame;
}

/// Depth along z of a ray d (d_z = 1) from the origin to a capped cylinder, by solving the
/// quadratic in double precision; infinity when it misses.
double CylinderDepth(const Solid& s, const Vector3d& d_W) {
  const Vector3d o = s.X_WG.inverse() * Vector3d::Zero();
  const Vector3d d = s.X_WG.linear().transpose() * d_W;
  const double r = s.shape.size_m.x();
  const double half = s.shape.size_m.y() / 2;
  double best = INFINITY;
  const double a = d.head<2>().squaredNorm();
  const double b = o.head<2>().dot(d.head<2>());
  const double root = b * b - a * (o.head<2>().squaredNorm() - r * r);
  if (root >= 0 && a > 0) {
    const double t = (-b - std::sqrt(root)) / a;
    if (t > 0 && std::abs(o.z() + t * d.z()) <= half) {
      best = t;
    }
  }
  for (const double cap : {-half, half}) {
    const double t = (cap - o.z()) / d.z();
    if (t > 0 && (o + t * d).head<2>().norm() <= r) {
      best = std::min(best, t);
    }
  }
  return best;
}

Vector3d Ray(const CameraIntrinsics& c, int pixel) {
  return {(pixel % c.width - c.cx) / c.fx, (pixel / c.width - c.cy) / c.fy, 1};
}

TEST(DepthCamera, HasTheFieldOfViewOfTheD455) {
  const DepthCamera camera({}, {}, kNoRobot, 1);
  const CameraIntrinsics& c = camera.intrinsics();
  EXPECT_NEAR(c.fx, 223.0 / 2, 0.5);  // half of what 424 x 240 has
  EXPECT_NEAR(2 * std::atan(c.height / 2.0 / c.fy) * 57.29577951308232, 57, 1);
  EXPECT_EQ(c.cx, 105.5);
  EXPECT_EQ(c.cy, 59.5);
}

TEST(DepthCamera, TracesPipesExactly) {
  std::vector<Solid> solids = {Wall(2.5)};
  for (int i = 0; i < 6; ++i) {
    Solid pipe;
    pipe.kind = SolidKind::kCylinder;
    pipe.shape = Shape::Cylinder(0.03 + 0.02 * i, 0.3 + 0.3 * i);
    pipe.X_WG = Eigen::Translation3d(0.3 * i - 0.8, 0.4 - 0.15 * i, 0.8 + 0.2 * i) *
                Eigen::AngleAxisd(0.4 * i + 0.2, Vector3d(1, 0.3 * i - 1, 0.5).normalized());
    solids.push_back(pipe);
  }
  DepthCamera camera({}, solids, kNoRobot, 1);
  const auto& traced = camera.Trace(Isometry3d::Identity(), {});
  int on_pipes = 0;
  int differ = 0;
  for (int i = 0; i < static_cast<int>(traced.size()); ++i) {
    const Vector3d d = Ray(camera.intrinsics(), i);
    double expected = 2.5;
    for (std::size_t k = 1; k < solids.size(); ++k) {
      expected = std::min(expected, CylinderDepth(solids[k], d));
    }
    on_pipes += expected < 2.5;
    differ += std::abs(traced[i].z_m - expected) > 1e-4;
  }
  EXPECT_GT(on_pipes, 2000);
  EXPECT_LE(differ, 5);  // rays that touch an outline within single precision
}

TEST(DepthCamera, MeasuresTheCosineOfIncidence) {
  Solid ball;
  ball.shape = Shape::Sphere(0.2);
  ball.X_WG.translation() = Vector3d(0, 0, 1);
  DepthCamera camera({}, {ball}, kNoRobot, 1);
  const auto& traced = camera.Trace(Isometry3d::Identity(), {});
  for (int i = 0; i < static_cast<int>(traced.size()); ++i) {
    if (traced[i].solid == 0) {
      const Vector3d d = Ray(camera.intrinsics(), i);
      const Vector3d n = (d * traced[i].z_m - Vector3d(0, 0, 1)).normalized();
      EXPECT_NEAR(traced[i].cosine, std::abs(n.dot(d.normalized())), 1e-3);
    }
  }
}

TEST(DepthCamera, SeesTheRobotsOwnBodiesWhereTheyAre) {
  RobotBodies robot;
  robot.links = 2;
  robot.bodies.push_back({"can", 1, 1, Shape::Cylinder(0.1, 0.4), Isometry3d::Identity()});
  robot.bodies.push_back({"brick", 0, 0, Shape::Box({0.1, 0.1, 0.1}), Isometry3d::Identity()});
  DepthCamera camera({}, {Wall(2)}, robot, 1);
  std::vector<Isometry3d> X_WL(2, Isometry3d::Identity());
  X_WL[0].translation() = Vector3d(0, 0, -1);  // behind the camera
  for (const double z : {1.0, 0.7, 5.0}) {
    X_WL[1] = Eigen::Translation3d(0.2, 0, z) * Eigen::AngleAxisd(0.3, Vector3d::UnitX());
    Solid same;
    same.kind = SolidKind::kCylinder;
    same.shape = robot.bodies[0].shape;
    same.X_WG = X_WL[1];
    const auto& traced = camera.Trace(Isometry3d::Identity(), X_WL);
    int seen = 0;
    int differ = 0;
    for (int i = 0; i < static_cast<int>(traced.size()); ++i) {
      const double expected = std::min(2.0, CylinderDepth(same, Ray(camera.intrinsics(), i)));
      seen += traced[i].solid == 1;
      EXPECT_NE(traced[i].solid, 2);
      differ += std::abs(traced[i].z_m - expected) > 1e-4;
    }
    EXPECT_EQ(seen > 100, z < 2);
    EXPECT_LE(differ, 2);
  }
}

/// Mean, standard deviation and count of the readings of a wall.
struct Statistics {
  double mean_m = 0;
  double sigma_m = 0;
  double share = 0;
};

Statistics OfWall(double z_m, const CameraSpec& spec = {}) {
  DepthCamera camera(spec, {Wall(z_m)}, kNoRobot, 3);
  double sum = 0;
  double squares = 0;
  int readings = 0;
  const int pixels = spec.width * spec.height;
  for (int k = 0; k < 4; ++k) {
    const auto frame = Shoot(camera);
    for (int i = 0; i < pixels; ++i) {
      if (frame->depth_mm[i] != 0) {
        const double error = frame->depth_mm[i] * 1e-3 - z_m;
        sum += error;
        squares += error * error;
        ++readings;
      }
    }
  }
  const double mean = sum / readings;
  return {z_m + mean, std::sqrt(squares / readings - mean * mean), readings / (4.0 * pixels)};
}

TEST(DepthCamera, HasNoiseThatGrowsWithTheSquareOfTheDepth) {
  for (const double z : {0.5, 1.0, 2.0, 4.0}) {
    const Statistics s = OfWall(z);
    const double sigma = 3.8e-3 * z * z;
    const double expected = std::sqrt(sigma * sigma + 1e-6 / 12);  // and rounding to millimetres
    EXPECT_NEAR(s.sigma_m, expected, 0.01 * expected) << z;        // 100 000 readings: 0.2 %
    EXPECT_NEAR(s.mean_m, z, 5 * expected / std::sqrt(100000)) << z;
    EXPECT_NEAR(s.share, 0.99, 0.002) << z;
  }
}

TEST(DepthCamera, WithoutNoiseReadsTheRoundedTruth) {
  CameraSpec spec;
  spec.noise_sigma_at_1m = 0;
  spec.invalid_fraction = 0;
  DepthCamera camera(spec, {Wall(1.2344)}, kNoRobot, 1);
  const auto frame = Shoot(camera);
  for (int i = 0; i < spec.width * spec.height; ++i) {
    EXPECT_EQ(frame->depth_mm[i], 1234);
  }
}

TEST(DepthCamera, ReadsNothingBeyondItsRange) {
  EXPECT_EQ(OfWall(6.1).share, 0);
  DepthCamera camera({}, {}, kNoRobot, 1);
  EXPECT_EQ(Shoot(camera)->depth_mm[5000], 0);
}

TEST(DepthCamera, BelowItsMinimumRangeReadsWrongOrNothing) {
  CameraSpec spec;
  spec.below_min_wrong_fraction = 0.1;
  DepthCamera camera(spec, {Wall(0.12)}, kNoRobot, 1);
  const auto frame = Shoot(camera);
  int readings = 0;
  int right = 0;
  int nearer = 0;
  int beyond = 0;
  for (int i = 0; i < spec.width * spec.height; ++i) {
    const int mm = frame->depth_mm[i];
    readings += mm != 0;
    right += std::abs(mm - 120) <= 2;
    nearer += mm != 0 && mm < 118;
    beyond += mm > 168;
  }
  EXPECT_NEAR(readings, 0.1 * 0.99 * spec.width * spec.height, 200);
  EXPECT_LT(right, readings / 10);
  EXPECT_GT(nearer, readings / 10);
  EXPECT_GT(beyond, readings / 10);
}

TEST(DepthCamera, LosesGrazedSurfacesAndHalfOfTheEdges) {
  Solid floor;  // 0.3 m below the camera, along its view
  floor.kind = SolidKind::kPlane;
  floor.X_WG =
      Eigen::Translation3d(0, 0.3, 0) * Eigen::AngleAxisd(3.141592653589793 / 2, Vector3d::UnitX());
  CameraSpec spec;
  spec.invalid_fraction = 0;
  DepthCamera camera(spec, {floor}, kNoRobot, 1);
  auto frame = Shoot(camera);
  const auto& traced = camera.Trace(Isometry3d::Identity(), {});
  for (int i = 0; i < spec.width * spec.height; ++i) {
    if (traced[i].z_m < 5.5F && traced[i].cosine > 0.21F && traced[i].z_m > 0.17F) {
      EXPECT_NE(frame->depth_mm[i], 0);
    }
    if (traced[i].cosine < 0.05F) {
      EXPECT_EQ(frame->depth_mm[i], 0);
    }
  }
  Solid post;
  post.shape = Shape::Box({0.3, 3, 0.01});
  post.X_WG.translation() = Vector3d(0, 0, 1);
  DepthCamera at_post(spec, {post, Wall(2)}, kNoRobot, 1);
  frame = Shoot(at_post);
  int lost = 0;
  for (int i = 0; i < spec.width * spec.height; ++i) {
    lost += frame->depth_mm[i] == 0;
  }
  EXPECT_NEAR(lost, 4 * spec.height / 2, 40);  // two edges, a pixel on either side
}

TEST(DepthCamera, StampsFramesAtItsRateAndRepeatsThemFromTheSeed) {
  DepthCamera a({}, {Wall(1)}, kNoRobot, 7);
  DepthCamera b({}, {Wall(1)}, kNoRobot, 7);
  DepthCamera c({}, {Wall(1)}, kNoRobot, 8);
  auto last = std::make_unique<DepthFrame>();
  for (int k = 0; k < 30; ++k) {
    EXPECT_NEAR(ToSeconds(a.next_stamp()), k / 15.0, 1e-9);
    const auto x = Shoot(a);
    const auto y = Shoot(b);
    const auto z = Shoot(c);
    EXPECT_EQ(x->depth_mm, y->depth_mm);
    EXPECT_NE(x->depth_mm, z->depth_mm);
    EXPECT_NE(x->depth_mm, last->depth_mm);
    EXPECT_EQ(x->sequence, static_cast<std::uint32_t>(k));
    EXPECT_EQ(x->stamp, y->stamp);
    *last = *x;
  }
}

TEST(DepthCamera, LosesAShareOfTheFramesTheSameWayForASeed) {
  CameraSpec spec;
  spec.lost_fraction = 0.3;
  DepthCamera a(spec, {Wall(1)}, kNoRobot, 7);
  DepthCamera b(spec, {Wall(1)}, kNoRobot, 7);
  std::uint32_t last = 0;
  constexpr int kFrames = 100;
  for (int k = 0; k < kFrames; ++k) {
    const Time due = a.next_stamp();
    const auto x = Shoot(a);
    EXPECT_EQ(x->stamp, due);
    EXPECT_NEAR(ToSeconds(x->stamp), x->sequence / 15.0, 1e-9);
    EXPECT_EQ(x->sequence, Shoot(b)->sequence);
    last = x->sequence;
  }
  // 143 at the mean; 3.3 standard deviations of the number that a hundred frames take.
  EXPECT_NEAR(last, kFrames / 0.7, 26);
}

TEST(ShippedScenarios, ShowNoPipeAtTheStart) {
  const RobotDescription description = TracerUf7Description();
  const RobotBodies robot = RobotBodiesOf(description);
  for (const ShippedToml& shipped : ShippedScenarios()) {
    const Scenario s = *LoadScenario(std::string(shipped.name)).scenario;
    RobotBodies::Pose pose;
    robot.forward(s.start.x_m, s.start.y_m, s.start.yaw_rad, s.start.joints_rad, pose);
    DepthCamera camera(s.camera, s.solids, robot, 1);
    int seen = 0;
    for (const auto& pixel : camera.Trace(pose.X_WL[description.LinkIndex("camera")], pose.X_WL)) {
      const bool solid = pixel.solid >= 0 && pixel.solid < static_cast<int>(s.solids.size());
      EXPECT_FALSE(solid && IsPipe(s.solids[pixel.solid]));
      seen += solid;
    }
    EXPECT_GT(seen, 20000) << s.name;
  }
}

}  // namespace
}  // namespace pipewright::hil
