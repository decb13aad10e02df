// SPDX-License-Identifier: MIT
#include "plan/motion/collision.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <vector>

#include "hil/plant/plant.h"
#include "plan/motion/edge.h"
#include "platform/core/rng.h"
#include "tests/plan/motion/cell.h"

namespace pipewright {
namespace {

/// Points of the plant's collision shapes in W, from the URDF and KDL: nothing of the checker's own
/// model.
class PlantPoints {
 public:
  struct Part {
    std::string link;
    const hil::CollisionShape* shape = nullptr;
    Isometry3d X_WG = Isometry3d::Identity();
    std::vector<Vector3d> points_W;
  };

  explicit PlantPoints(const Configuration& q) {
    const hil::Plant plant(description_, {q(0), q(1), q(2)}, q.tail<kArmJoints>());
    for (const hil::CollisionShape& shape : description_.shapes) {
      Part part{shape.link, &shape, plant.X_WL(plant.LinkIndex(shape.link)) * shape.X_LG, {}};
      constexpr int kSteps = 8;
      for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; j <= kSteps; ++j) {
          AddFaces(2.0 * i / kSteps - 1, 2.0 * j / kSteps - 1, part);
        }
      }
      parts_.push_back(part);
    }
  }

  const std::vector<Part>& parts() const { return parts_; }

  /// Of a point to a part, 0 inside.
  static double Distance(const Part& part, const Vector3d& p_W) {
    const Vector3d p_G = part.X_WG.inverse() * p_W;
    if (part.shape->kind == hil::CollisionShape::Kind::kBox) {
      return (p_G.cwiseAbs() - part.shape->size_m / 2).cwiseMax(0).norm();
    }
    return Eigen::Vector2d{p_G.head<2>().norm() - part.shape->size_m.x(),
                           std::abs(p_G.z()) - part.shape->size_m.z() / 2}
        .cwiseMax(0)
        .norm();
  }

 private:
  static void AddFaces(double a, double b, Part& part) {
    const Vector3d& size = part.shape->size_m;
    if (part.shape->kind == hil::CollisionShape::Kind::kBox) {
      for (const double c : {-1.0, 1.0}) {
        for (const Vector3d& p : {Vector3d{a, b, c}, Vector3d{a, c, b}, Vector3d{c, a, b}}) {
          part.points_W.push_back(part.X_WG * p.cwiseProduct(size / 2));
        }
      }
      return;
    }
    const double angle = std::numbers::pi * a;
    const Vector3d rim = size.x() * Vector3d{std::cos(angle), std::sin(angle), 0};
    const Vector3d up{0, 0, size.z() / 2};
    part.points_W.push_back(part.X_WG * (rim + b * up));
    part.points_W.push_back(part.X_WG * ((b + 1) / 2 * rim + up));
    part.points_W.push_back(part.X_WG * ((b + 1) / 2 * rim - up));
  }

  hil::RobotDescription description_ = hil::TracerUf7Description();
  std::vector<Part> parts_;
};

/// Centres of the map's obstacles with z >= z_lo, for brute force.
std::vector<Vector3d> ObstacleCenters(const VoxelGrid& map, int z_lo) {
  std::vector<Vector3d> centers;
  for (int i = 0; i < map.voxel_count(); ++i) {
    if (map.ObstacleAt(i) && map.VoxelAt(i).z >= z_lo) {
      centers.push_back(map.Center(map.VoxelAt(i)));
    }
  }
  return centers;
}

/// Least distance of a part's points to the voxels, or what is enough for every test here.
double DistanceToVoxels(const PlantPoints::Part& part, const std::vector<Vector3d>& centers) {
  constexpr double kHalf_m = 0.025;
  constexpr double kEnough_m = 0.15;
  constexpr double kLongestPart_m = 0.45;
  double least = kEnough_m;
  for (const Vector3d& center : centers) {
    if ((center - part.X_WG.translation()).norm() > kLongestPart_m + 2 * kHalf_m + kEnough_m) {
      continue;
    }
    if (PlantPoints::Distance(part, center) > 2 * kHalf_m + least) {
      continue;
    }
    for (const Vector3d& p_W : part.points_W) {
      const Vector3d beyond = (p_W - center).cwiseAbs().array() - kHalf_m;
      least = std::min(least, beyond.cwiseMax(0).norm());
    }
  }
  return least;
}

Configuration NearStart(Rng& rng) {
  Configuration q = test::Cell::Start();
  q(0) += rng.Uniform(-0.2, 0.6);
  q(1) += rng.Uniform(-0.2, 0.2);
  q(2) += rng.Uniform(-3, 3);
  for (int i = 0; i < kArmJoints; ++i) {
    q(3 + i) += rng.Uniform(-1, 1);
  }
  return q;
}

TEST(CollisionChecker, WhatIsFreeKeepsThePlantClearOfTheWorldAndOfItself) {
  constexpr double kCover_m = 0.005;  // what our outline leaves of the plant's shapes
  test::Cell cell;
  cell.AddThreePipes();
  const CollisionChecker checker(cell.around());
  const CollisionConfig config;
  const std::vector<Vector3d> obstacles = ObstacleCenters(cell.map(), 0);  // not the floor
  Rng rng(81);
  int free = 0;
  while (free < 8) {
    const Configuration q = NearStart(rng);
    if (!checker.Free(q)) {
      continue;
    }
    ++free;
    const PlantPoints plant(q);
    for (const PlantPoints::Part& part : plant.parts()) {
      SCOPED_TRACE(part.link + " " + part.shape->name);
      const bool chassis = part.link == "base_link";
      const double least_m = DistanceToVoxels(part, obstacles);
      double self_m = 1e9;
      for (const Vector3d& p_W : part.points_W) {
        for (const PlantPoints::Part& other : plant.parts()) {
          const bool hand = part.link == "tool" || part.link == "link7" || part.link == "link6";
          if (chassis ? other.link == "link5" || other.link == "tool"
                      : hand && (other.link == "link2" || other.link == "link1")) {
            self_m = std::min(self_m, PlantPoints::Distance(other, p_W));
          }
        }
      }
      EXPECT_GE(least_m, (chassis ? config.voxel_margin_m : config.margin_m) - kCover_m);
      EXPECT_GE(self_m, config.self_m - kCover_m);
    }
    for (const PlaneEstimate& plane : cell.around().scene.planes) {
      const Kinematics<kArmJoints> body(TracerUf7(), q);
      EXPECT_GE(plane.n_W.dot(body.p_WS()) - plane.d_m, config.plane_m - 0.05);
    }
  }
}

struct Case {
  const char* name;
  Configuration q;
  void (*add)(test::Cell&);
};

Configuration With(int coordinate, double value) {
  Configuration q = test::Cell::Start();
  q(coordinate) = value;
  return q;
}

TEST(CollisionChecker, EachKindOfObstacleIsSeen) {
  const auto nothing = [](test::Cell&) {};
  const Configuration start = test::Cell::Start();  // sensor near (0.73, 0.75, 0.90)
  const Case cases[] = {
      {"a joint beyond its limit", With(4, -2.05), nothing},
      {"a wrist folded into the forearm", With(8, 3.05), nothing},
      {"an arm folded into the base", With(4, 2.05), nothing},
      {"an occupied voxel at the camera", start,
       [](test::Cell& cell) {
         cell.AddBox({0.77, 0.75, 0.9}, {0.77, 0.75, 0.9});
       }},
      {"a box beside the base", start,
       [](test::Cell& cell) {
         cell.AddBox({0.35, 1.04, 0.06}, {0.4, 1.04, 0.1});
       }},
      {"a wall too near the base's centre", start,
       [](test::Cell& cell) {
         cell.AddPlane({-0.1, 0.75, 0.3}, Vector3d::UnitY(), Vector3d::UnitZ(), 0.3, 0.3);
       }},
      {"a ceiling too near the arm", start,
       [](test::Cell& cell) {
         cell.AddPlane({0.5, 0.75, 1.0}, Vector3d::UnitY(), Vector3d::UnitX(), 0.5, 0.5);
       }},
      {"a pipe that the map does not hold", start,
       [](test::Cell& cell) {
         PipeEstimate pipe;
         pipe.p_W = {0.80, 0.75, 0.9};
         pipe.l_W = Vector3d::UnitY();
         pipe.radius_m = 0.03;
         pipe.extent_lo_m = -0.1;
         pipe.extent_hi_m = 0.1;
         static_cast<void>(cell.scene().pipes.push_back(pipe));
       }},
      {"not a number", With(3, std::numeric_limits<double>::quiet_NaN()), nothing},
  };
  {
    const test::Cell empty;
    EXPECT_TRUE(CollisionChecker(empty.around()).Free(start));
  }
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    test::Cell cell;
    c.add(cell);
    EXPECT_FALSE(CollisionChecker(cell.around()).Free(c.q));
  }
}

TEST(CollisionChecker, PrimitivesEndWhereTheyWereSeenToEnd) {
  const Configuration start = test::Cell::Start();
  test::Cell cell;
  cell.AddPlane({0.5, 3.0, 1.0}, Vector3d::UnitY(), Vector3d::UnitX(), 0.5, 0.5);
  cell.AddPlane({0.35, 0.75, 0.0}, Vector3d::UnitX(), Vector3d::UnitY(), 2, 2);  // the floor
  PipeEstimate pipe;
  pipe.p_W = {0.85, 1.6, 0.9};
  pipe.l_W = Vector3d::UnitY();
  pipe.radius_m = 0.03;
  pipe.extent_lo_m = -0.2;
  pipe.extent_hi_m = 0.2;
  static_cast<void>(cell.scene().pipes.push_back(pipe));
  EXPECT_TRUE(CollisionChecker(cell.around()).Free(start));
}

TEST(CollisionChecker, UnknownSpaceIsAnObstacle) {
  MapConfig config;
  const VoxelGrid unknown(config);
  DistanceField field(config);
  field.Update(unknown);
  const Scene scene;
  const CollisionChecker checker({field, unknown, scene});
  EXPECT_FALSE(checker.Free(test::Cell::Start()));
  EXPECT_LT(checker.Clearance(test::Cell::Start()), 0);
}

TEST(CollisionChecker, ClearanceIsALowerBoundOfThePlants) {
  constexpr double kSlip_m =
      0.005 + 0.25 * 0.05;  // the outline's, and the field's beyond one voxel
  test::Cell cell;
  cell.AddThreePipes();
  const CollisionChecker checker(cell.around());
  const std::vector<Vector3d> obstacles = ObstacleCenters(cell.map(), -2);
  Rng rng(82);
  for (int trial = 0; trial < 4; ++trial) {
    const Configuration q = NearStart(rng);
    const double clearance_m = checker.Clearance(q);
    const PlantPoints plant(q);
    for (const PlantPoints::Part& part : plant.parts()) {
      if (part.link != "base_link") {
        EXPECT_GE(DistanceToVoxels(part, obstacles), std::min(clearance_m, 0.15) - kSlip_m);
      }
    }
  }
}

TEST(CollisionChecker, AnEdgeIsFreeOnlyIfItsMiddleIs) {
  test::Cell cell;
  const Configuration a = test::Cell::Start();
  const Configuration b = With(3, 1.2);
  EXPECT_TRUE(CollisionChecker(cell.around()).FreeEdge(a, b));
  const Kinematics<kArmJoints> middle(TracerUf7(), EdgeAt(a, b, 0.5));
  const Vector3d ahead_W = middle.p_WS() + 0.08 * middle.z_WS();
  cell.AddBox(ahead_W, ahead_W);
  const CollisionChecker checker(cell.around());
  EXPECT_TRUE(checker.Free(a));
  EXPECT_TRUE(checker.Free(b));
  EXPECT_FALSE(checker.FreeEdge(a, b));
}

TEST(CollisionChecker, RelaxedAcceptsWhatItWasMadeForAndNothingDeeper) {
  test::Cell cell;
  cell.AddThreePipes();
  const CollisionChecker checker(cell.around());
  Rng rng(83);
  int inside = 0;
  for (int trial = 0; trial < 3000 && inside < 20; ++trial) {
    const Configuration q = NearStart(rng);
    const double clearance_m = checker.Clearance(q);
    if (checker.Free(q) || clearance_m < 0.012) {
      continue;
    }
    ++inside;
    const CollisionChecker relaxed = checker.RelaxedTo(q);
    EXPECT_TRUE(relaxed.Free(q));
    for (int i = 0; i < 30; ++i) {
      Configuration other = q;
      for (int j = 0; j < kArmJoints; ++j) {
        other(3 + j) += rng.Uniform(-0.3, 0.3);
      }
      const double least_m = std::min(clearance_m, 0.032) - 0.001;
      EXPECT_TRUE(checker.Clearance(other) >= least_m || !relaxed.Free(other));
    }
  }
  EXPECT_EQ(inside, 20);
}

}  // namespace
}  // namespace pipewright
