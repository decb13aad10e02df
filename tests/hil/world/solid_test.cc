// SPDX-License-Identifier: MIT
#include "hil/world/solid.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "hil/world/ray_scene.h"
#include "platform/core/rng.h"

namespace pipewright::hil {
namespace {

/// A box as a mesh; the last triangle may be left out.
Mesh BoxMesh(const Vector3d& size_m, const Isometry3d& X_WG, bool complete = true) {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(X_WG * size_m.cwiseProduct(
                                 Vector3d((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5)));
  }
  std::vector<Mesh::Triangle> t = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                   {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                   {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  if (!complete) {
    t.pop_back();
  }
  return Mesh(corners, t);
}

Isometry3d RandomPose(Rng& rng, double spread_m) {
  const Vector3d p(rng.Normal(), rng.Normal(), rng.Normal());
  const Vector3d axis(rng.Normal(), rng.Normal(), rng.Normal());
  return Eigen::Translation3d(p * spread_m) *
         Eigen::AngleAxisd(rng.Uniform(-std::numbers::pi, std::numbers::pi), axis.normalized());
}

Solid MeshSolid(const Mesh& mesh) {
  Solid solid;
  solid.kind = SolidKind::kMesh;
  solid.mesh = std::make_shared<Mesh>(mesh);
  return solid;
}

TEST(Mesh, OfABoxIsAsFarAsTheBox) {
  Rng rng(21);
  int apart = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d size(rng.Uniform(0.1, 1), rng.Uniform(0.1, 1), rng.Uniform(0.1, 1));
    Solid box;
    box.shape = Shape::Box(size);
    box.X_WG = RandomPose(rng, 0.5);
    const Solid mesh = MeshSolid(BoxMesh(size, box.X_WG));
    const Shape other = i % 2 == 0 ? Shape::Cylinder(0.05, 0.4) : Shape::Box({0.1, 0.3, 0.2});
    const Isometry3d X_WS = RandomPose(rng, 0.5);
    EXPECT_NEAR(Distance(mesh, other, X_WS), Distance(box, other, X_WS), 3e-8);
    const Vector3d p = RandomPose(rng, 0.5).translation();
    EXPECT_NEAR(Distance(mesh, p), std::max(Distance(box, p), 0.0), 3e-8);
    EXPECT_EQ(mesh.mesh->Inside(p), Distance(box, p) < 0);
    apart += Distance(box, p) > 0;
  }
  EXPECT_GT(apart, 500);
  EXPECT_LT(apart, 2000);
}

TEST(Mesh, IsClosedOnlyWithEveryTriangle) {
  EXPECT_TRUE(BoxMesh({1, 1, 1}, Isometry3d::Identity()).closed());
  EXPECT_FALSE(BoxMesh({1, 1, 1}, Isometry3d::Identity(), false).closed());
  EXPECT_FALSE(Mesh({}, {}).closed());
}

TEST(Mesh, ThatIsOpenHasNoInside) {
  const Solid open = MeshSolid(BoxMesh({1, 1, 1}, Isometry3d::Identity(), false));
  EXPECT_NEAR(Distance(open, Vector3d::Zero()), 0.5, 1e-8);
}

TEST(LoadMesh, ReadsAnStlInMillimetresWherePlaced) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "pipewright_test.stl";
  std::ofstream(file)
      << "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1000 0 0\n"
         "vertex 0 1000 0\nendloop\nendfacet\nendsolid one\n";
  Mesh mesh;
  std::string error;
  const Isometry3d X_WG = Isometry3d(Eigen::Translation3d(0, 0, 2));
  ASSERT_TRUE(LoadMesh(file.string(), 0.001, X_WG, mesh, error)) << error;
  ASSERT_EQ(mesh.triangles().size(), 1U);
  EXPECT_TRUE(mesh.lo_W().isApprox(Vector3d(0, 0, 2), 1e-9));
  EXPECT_TRUE(mesh.hi_W().isApprox(Vector3d(1, 1, 2), 1e-9));
  std::filesystem::remove(file);
}

TEST(LoadMesh, SaysWhyAFileIsNoMesh) {
  Mesh mesh;
  std::string error;
  EXPECT_FALSE(LoadMesh("/nonexistent.stl", 1, Isometry3d::Identity(), mesh, error));
  EXPECT_FALSE(error.empty());
}

TEST(Solid, PlaneIsAsFarAsTheLowestPoint) {
  Solid plane;
  plane.kind = SolidKind::kPlane;
  const Isometry3d X_WS =
      Eigen::Translation3d(3, 4, 1) * Eigen::AngleAxisd(std::numbers::pi / 4, Vector3d::UnitX());
  EXPECT_NEAR(Distance(plane, Shape::Cylinder(0.1, 0.6), X_WS),
              1 - (0.1 + 0.3) / std::numbers::sqrt2, 1e-12);
  EXPECT_EQ(Distance(plane, Shape::Sphere(1.5), X_WS), 0);
  EXPECT_DOUBLE_EQ(Distance(plane, Vector3d(7, 7, -2)), -2);
}

// Oracle: points along the way, each asked whether it is inside a solid.
TEST(RayScene, IsOccludedWhereTheWayPassesThroughASolid) {
  std::vector<Solid> solids(3);
  solids[0].kind = SolidKind::kCylinder;
  solids[0].shape = Shape::Cylinder(0.2, 1.0);
  solids[0].X_WG =
      Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized());
  solids[1].shape = Shape::Box({0.4, 0.3, 0.2});
  solids[1].X_WG = Eigen::Translation3d(-0.5, 0, 0) * Eigen::AngleAxisd(0.4, Vector3d::UnitY());
  solids[2].kind = SolidKind::kPlane;
  solids[2].X_WG = Eigen::Translation3d(0, 0, -0.6);
  const RayScene scene(solids);
  Rng rng(22);
  int occluded = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d a = RandomPose(rng, 0.6).translation();
    const Vector3d b = RandomPose(rng, 0.6).translation();
    double nearest = 1e9;
    for (int k = 0; k <= 1000; ++k) {
      for (const Solid& solid : solids) {
        nearest = std::min(nearest, Distance(solid, a + (b - a) * (k / 1000.0)));
      }
    }
    bool starts_inside = false;
    for (const Solid& solid : solids) {
      starts_inside = starts_inside || Distance(solid, a) < 0 || Distance(solid, b) < 0;
    }
    if (starts_inside || std::abs(nearest) < 0.005) {
      continue;  // only surfaces are seen, and the oracle's steps are coarse
    }
    ASSERT_EQ(scene.Occluded(a, b), nearest < 0) << i;
    occluded += nearest < 0;
  }
  EXPECT_GT(occluded, 120);
}

TEST(RayScene, SeesTheSurfaceItselfThroughTheGap) {
  std::vector<Solid> solids(1);
  solids[0].kind = SolidKind::kCylinder;
  solids[0].shape = Shape::Cylinder(0.05, 1);
  const RayScene scene(solids);
  EXPECT_FALSE(scene.Occluded({0.4, 0, 0}, {0.05, 0, 0}));
  EXPECT_TRUE(scene.Occluded({0.4, 0, 0}, {-0.05, 0, 0}));
  EXPECT_TRUE(scene.Occluded({0.02, 0, 0.9}, {0.02, 0, -0.9}));  // through both caps
}

}  // namespace
}  // namespace pipewright::hil
