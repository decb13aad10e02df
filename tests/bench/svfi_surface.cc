// SPDX-License-Identifier: MIT
#include "tests/bench/svfi_surface.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/ctrl/constraints/random_world.h"

namespace pipewright::bench {
namespace {

/// Where a robot point is fixed: its body and its place there.
struct Place {
  int body = 0;
  Vector3d p_L;
};
Place PlaceOf(int point) {
  const RobotShapes& shapes = TracerUf7Shapes();
  if (point < shapes.spheres.size()) {
    return {shapes.spheres[point].body, shapes.spheres[point].p_L};
  }
  if (point < BasePoint()) {
    const Eigen::Vector2d& p_B = shapes.discs[point - shapes.spheres.size()].p_B;
    return {0, {p_B.x(), p_B.y(), 0}};
  }
  return {0, {0, 0, 0.1}};
}

}  // namespace

int BasePoint() { return TracerUf7Shapes().spheres.size() + TracerUf7Shapes().discs.size(); }

double EtaOf(Primitive primitive) {
  const ConstraintConfig c;
  return primitive == Primitive::kVoxel ? c.eta_voxel_1ps : c.eta_1ps;
}

double SafeOf(Primitive primitive, int point) {
  const ConstraintConfig c;
  const RobotShapes& shapes = TracerUf7Shapes();
  if (point == BasePoint()) {
    return c.d_safe_base_plane_m;
  }
  const int spheres = shapes.spheres.size();
  const double r_m =
      point < spheres ? shapes.spheres[point].r_m : shapes.discs[point - spheres].r_m;
  if (primitive == Primitive::kVoxel) {
    return r_m + c.voxel_margin_m;
  }
  return std::max(primitive == Primitive::kPlane ? c.d_safe_plane_m : c.d_safe_pipe_m,
                  r_m + c.margin_m);
}

const StateCovariance& UnsureState() {
  static const StateCovariance unsure = [] {
    StateCovariance c;
    c.base.diagonal().setConstant(9e-6);
    c.joint_rad2.setConstant(1e-6);
    return c;
  }();
  return unsure;
}

Configuration DrawState(const Configuration& q, Rng& rng) {
  Configuration drawn = q;
  for (int i = 0; i < kDof; ++i) {
    const double variance = i < 3 ? UnsureState().base(i, i) : UnsureState().joint_rad2(i - 3);
    drawn(i) += std::sqrt(variance) * rng.Normal();
  }
  return drawn;
}

Vector3d PointAt(const Configuration& q, int point) {
  const Place place = PlaceOf(point);
  return Kinematics<kArmJoints>(TracerUf7(), q).Point(place.body, place.p_L);
}

Mat<3, kControls> JacobianAt(const Configuration& q, int point) {
  const Place place = PlaceOf(point);
  return Kinematics<kArmJoints>(TracerUf7(), q).PointJacobian(place.body, place.p_L);
}

const DistanceField& Surface::Field() const {
  static const std::vector<test::VoxelWorld> worlds = [] {
    std::vector<test::VoxelWorld> made(1 + kPosts);
    for (int width = 1; width <= kPosts; ++width) {
      test::VoxelWorld& world = made[static_cast<std::size_t>(width)];
      for (int i = 0; i < width; ++i) {
        for (int j = 0; j < width; ++j) {
          for (int k = -2; k < 29; ++k) {
            world.AddObstacle(
                {kPostAt_m + kVoxel_m * (i + 0.5), kVoxel_m * (j + 0.5), kVoxel_m * (k + 0.5)});
          }
        }
      }
      world.Update();
    }
    return made;
  }();
  const bool post = kind == Primitive::kVoxel;
  return worlds[static_cast<std::size_t>(post ? std::lround(2 * half_m / kVoxel_m) : 0)].field();
}

Scene Surface::ToScene() const {
  Scene scene;
  if (kind == Primitive::kPlane) {
    (void)scene.planes.push_back(test::MakePlane(1, p, axis, half_m, sigma_rad, sigma_m));
  } else if (kind != Primitive::kVoxel) {
    (void)scene.pipes.push_back(test::MakePipe(1, p, axis, radius_m, half_m, sigma_m, sigma_rad));
  }
  return scene;
}

Surface Surface::Draw(Rng& rng) const {
  if (kind == Primitive::kVoxel) {
    Surface moved = *this;
    moved.p += sigma_m * Vector3d(rng.Normal(), rng.Normal(), 0);
    return moved;
  }
  const Vector3d a = axis.unitOrthogonal();
  const Vector3d b = axis.cross(a);
  Surface drawn = *this;
  const Vector3d tilt = sigma_rad * (rng.Normal() * a + rng.Normal() * b);
  const double angle = tilt.norm();
  drawn.axis = angle > 0 ? Vector3d(std::cos(angle) * axis + std::sin(angle) / angle * tilt) : axis;
  if (kind == Primitive::kPlane) {
    drawn.p += sigma_m * rng.Normal() * drawn.axis;
  } else {
    drawn.p += sigma_m * (rng.Normal() * a + rng.Normal() * b);
    drawn.radius_m += sigma_m / 2 * rng.Normal();
  }
  return drawn;
}

}  // namespace pipewright::bench
