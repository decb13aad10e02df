// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "plan/motion/surroundings.h"
#include "platform/robot/kinematics.h"
#include "platform/robot/robot.h"
#include "platform/robot/uf7.h"

namespace pipewright::test {

/// A known world: what is not put into it is free.
class Cell {
 public:
  Cell() : map_(Config()), field_(Config()) {
    const double width = map_.config().width_m;
    for (double x = -1; x <= 2.5; x += 8 * width) {
      for (double y = -1; y <= 2.5; y += 8 * width) {
        for (double z = -0.2; z <= 2; z += 8 * width) {
          map_.MarkSweptSphere({x, y, z}, 8 * width);
        }
      }
    }
    Update();
  }

  /// Fills the voxels of a box with points, so that they are occupied.
  void AddBox(const Vector3d& lo_W, const Vector3d& hi_W) {
    const double step = map_.config().width_m / 2;
    std::vector<Vector3f> points;
    for (double x = lo_W.x(); x <= hi_W.x(); x += step) {
      for (double y = lo_W.y(); y <= hi_W.y(); y += step) {
        for (double z = lo_W.z(); z <= hi_W.z(); z += step) {
          points.push_back(Vector3d{x, y, z}.cast<float>());
        }
      }
    }
    Insert(points);
  }

  /// The surface of a pipe of finite length, in the map and in the scene.
  void AddPipe(const Vector3d& from_W, const Vector3d& to_W, double radius_m) {
    PipeEstimate pipe;
    pipe.id = static_cast<std::uint32_t>(scene_.pipes.size() + 1);
    pipe.p_W = (from_W + to_W) / 2;
    pipe.l_W = (to_W - from_W).normalized();
    pipe.radius_m = radius_m;
    pipe.extent_hi_m = (to_W - from_W).norm() / 2;
    pipe.extent_lo_m = -pipe.extent_hi_m;
    const Vector3d e1 = pipe.l_W.unitOrthogonal();
    const Vector3d e2 = pipe.l_W.cross(e1);
    std::vector<Vector3f> points;
    for (double s = pipe.extent_lo_m; s <= pipe.extent_hi_m; s += 0.02) {
      for (double a = 0; a < 6.28; a += 0.2) {
        points.push_back(
            (pipe.p_W + s * pipe.l_W + radius_m * (std::cos(a) * e1 + std::sin(a) * e2))
                .cast<float>());
      }
    }
    static_cast<void>(scene_.pipes.push_back(pipe));
    Insert(points);
  }

  /// A rectangle seen as a plane with normal n = e1 x e2; in the scene only.
  void AddPlane(const Vector3d& p_WCentroid, const Vector3d& e1_W, const Vector3d& e2_W,
                double half1_m, double half2_m) {
    PlaneEstimate plane;
    plane.id = static_cast<std::uint32_t>(scene_.planes.size() + 1);
    plane.n_W = e1_W.cross(e2_W);
    plane.d_m = plane.n_W.dot(p_WCentroid);
    plane.p_WCentroid = p_WCentroid;
    plane.e1_W = e1_W;
    plane.e2_W = e2_W;
    plane.extent_lo_m[0] = -half1_m;
    plane.extent_hi_m[0] = half1_m;
    plane.extent_lo_m[1] = -half2_m;
    plane.extent_hi_m[1] = half2_m;
    static_cast<void>(scene_.planes.push_back(plane));
  }

  /// The cell of the product: floor, three walls, an open front at x = 0, three pipes.
  void AddThreePipes() {
    AddBox({-0.5, -0.5, -0.04}, {1.99, 1.99, -0.01});
    AddBox({1.51, 0, 0}, {1.54, 1.5, 1.45});
    AddBox({0, -0.04, 0}, {1.5, -0.01, 1.45});
    AddBox({0, 1.51, 0}, {1.5, 1.54, 1.45});
    AddPlane({0.75, 0.75, 0}, Vector3d::UnitX(), Vector3d::UnitY(), 0.75, 0.75);
    AddPlane({1.5, 0.75, 0.75}, Vector3d::UnitZ(), Vector3d::UnitY(), 0.75, 0.75);
    AddPlane({0.75, 0, 0.75}, Vector3d::UnitZ(), Vector3d::UnitX(), 0.75, 0.75);
    AddPlane({0.75, 1.5, 0.75}, Vector3d::UnitX(), Vector3d::UnitZ(), 0.75, 0.75);
    AddPipe({1.25, 1.2, 0}, {1.25, 1.2, 1.5}, 0.06);
    AddPipe({1.3, 0, 0.9}, {1.3, 1.5, 0.9}, 0.05);
    AddPipe({0, 0.2, 0.55}, {1.5, 0.2, 0.55}, 0.05);
  }

  Surroundings around() const { return {field_, map_, scene_}; }
  const VoxelGrid& map() const { return map_; }
  Scene& scene() { return scene_; }

  /// Where the mission starts: at the open front, arm folded.
  static Configuration Start() {
    Configuration q;
    q << 0.35, 0.75, 0, HomeJoints(TracerUf7());
    return q;
  }

 private:
  static MapConfig Config() {
    MapConfig config;
    config.lo = {-10, -10, -2};
    config.hi = {39, 39, 33};
    config.workspace_lo = {2, 2, 2};
    config.workspace_hi = {27, 27, 27};
    config.brick_capacity = BricksOfBox(config);
    return config;
  }

  void Insert(const std::vector<Vector3f>& points) {
    // From inside the wanted surface: each ray stays within the voxel it ends in.
    for (const Vector3f& point : points) {
      static_cast<void>(map_.InsertScan(&point, 1, point, -1));
    }
    Update();
  }

  void Update() { field_.Update(map_); }

  VoxelGrid map_;
  DistanceField field_;
  Scene scene_;
};

}  // namespace pipewright::test
