// SPDX-License-Identifier: MIT
#include "tests/bench/primitives_rooms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pipewright::bench {
namespace {

constexpr int kFramesPerRoom = 10;

Matrix3d WithZ(const Vector3d& z) {
  Matrix3d R;
  R.col(2) = z;
  R.col(0) = z.unitOrthogonal();
  R.col(1) = z.cross(R.col(0));
  return R;
}

void AddPlane(const Vector3d& n_W, double d_m, Room& room) {
  hil::Solid solid;
  solid.kind = hil::SolidKind::kPlane;
  solid.X_WG.linear() = WithZ(n_W);
  solid.X_WG.translation() = d_m * n_W;
  room.solids.push_back(solid);
  room.planes.push_back({n_W, d_m});
}

void AddPipe(const Vector3d& p_W, const Vector3d& l_W, double radius_m, double length_m,
             Room& room) {
  hil::Solid solid;
  solid.kind = hil::SolidKind::kCylinder;
  solid.shape = hil::Shape::Cylinder(radius_m, length_m);
  solid.X_WG.linear() = WithZ(l_W);
  solid.X_WG.translation() = p_W;
  room.solids.push_back(solid);
  room.pipes.push_back({p_W, l_W, radius_m});
}

Vector3d Direction(Rng& rng) {
  return Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
}

/// Four walls, not quite square, floor and ceiling; up to three pipes that hang free.
Room MakeRoom(const FrameCase& c, Rng& rng) {
  Room room;
  const double turn = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  for (int axis = 0; axis < 2; ++axis) {
    room.half_m[axis] = rng.Uniform(c.room_lo_m, c.room_hi_m);
  }
  room.half_m.z() = rng.Uniform(0.8, 1.5);
  for (int wall = 0; wall < 4; ++wall) {
    const double yaw = turn + wall * std::numbers::pi / 2 + 0.05 * rng.Normal();
    AddPlane({-std::cos(yaw), -std::sin(yaw), 0}, -room.half_m[wall % 2], room);
  }
  AddPlane(Vector3d::UnitZ(), -room.half_m.z(), room);
  AddPlane(-Vector3d::UnitZ(), -room.half_m.z(), room);
  const int pipes = rng.Index(4);
  for (int k = 0; k < pipes; ++k) {
    const double reach = 0.5 * room.half_m.head<2>().minCoeff();
    const Vector3d p_W{rng.Uniform(-reach, reach), rng.Uniform(-reach, reach),
                       rng.Uniform(-0.5, 0.5)};
    AddPipe(p_W, Direction(rng), rng.Uniform(0.025, 0.14), rng.Uniform(0.5, 3.0), room);
  }
  return room;
}

Isometry3d LookingAlong(const Vector3d& eye_W, const Vector3d& z_W, double roll_rad) {
  Isometry3d X_WS = Isometry3d::Identity();
  X_WS.linear() = WithZ(z_W) * Eigen::AngleAxisd(roll_rad, Vector3d::UnitZ()).toRotationMatrix();
  X_WS.translation() = eye_W;
  return X_WS;
}

bool Free(const Room& room, const Vector3d& p_W) {
  constexpr double kClear_m = 0.2;
  return std::all_of(room.solids.begin(), room.solids.end(),
                     [&](const hil::Solid& solid) { return hil::Distance(solid, p_W) > kClear_m; });
}

/// Half of the poses face a pipe from the case's distances, half anything from anywhere.
Isometry3d MakePose(const FrameCase& c, const Room& room, Rng& rng) {
  for (;;) {
    const double roll_rad = rng.Uniform(-std::numbers::pi, std::numbers::pi);
    Vector3d eye_W = Vector3d::Zero();
    Vector3d target_W = Vector3d::Zero();
    if (!room.pipes.empty() && rng.Uniform() < 0.5) {
      const TruePipe& pipe = room.pipes[rng.Index(static_cast<int>(room.pipes.size()))];
      const Vector3d side = pipe.l_W.cross(Direction(rng)).normalized();
      target_W = pipe.p_W + rng.Uniform(-0.2, 0.2) * pipe.l_W;
      eye_W = target_W + (pipe.radius_m + rng.Uniform(c.near_m, c.far_m)) * side +
              rng.Uniform(-0.3, 0.3) * pipe.l_W;
      target_W += 0.1 * Direction(rng);
    } else {
      for (int axis = 0; axis < 3; ++axis) {
        eye_W[axis] = rng.Uniform(-0.8, 0.8) * room.half_m[axis];
      }
      target_W = eye_W + Direction(rng);
    }
    if (Free(room, eye_W)) {
      return LookingAlong(eye_W, (target_W - eye_W).normalized(), roll_rad);
    }
  }
}

}  // namespace

void FrameSource::Next(DepthFrame& frame) {
  if (count_ % kFramesPerRoom == 0) {
    room_ = MakeRoom(case_, rng_);
    camera_ = std::make_unique<hil::DepthCamera>(case_.camera, room_.solids, hil::RobotBodies{},
                                                 seed_ * 1000003 + count_);
  }
  ++count_;
  X_WS_ = MakePose(case_, room_, rng_);
  camera_->Render(X_WS_, {}, frame);
}

}  // namespace pipewright::bench
