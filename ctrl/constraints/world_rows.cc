// SPDX-License-Identifier: MIT
#include "ctrl/constraints/world_rows.h"

#include <algorithm>
#include <cmath>

namespace pipewright {
namespace {

constexpr double kSamePoint_m = 0.01;
constexpr double kInside_m = 1e-9;  // of an obstacle
/// Height at which the base's centre is held against walls: mid height of the platform.
constexpr double kBaseHeight_m = 0.1;

RobotPoint MakePoint(const RowContext& c, int body, const Vector3d& p_L, double r_m) {
  RobotPoint point;
  point.p_W = c.kinematics.Point(body, p_L);
  point.J = c.kinematics.PointJacobianAt(body, point.p_W);
  point.r_m = r_m;
  point.buffer_mps = HoldBuffer(point.J, c.u_max, c.config.period_s);
  if (c.covariance_q != nullptr) {
    point.spread = SpreadOf(c.covariance_q->joint_rad2, point.J);
  }
  return point;
}

void AddPlane(const RowContext& c, RowKind kind, int index, const PlaneEstimate& plane,
              const Matrix3d* base, double d_safe_m, const RobotPoint& point, RowMaker& maker,
              Clearances& clearance) {
  const SlabDistance distance =
      PointToSlab(point.p_W, plane, c.config.plane_inflation_m, c.config.plane_behind_m);
  if (kind == RowKind::kPlane) {
    clearance.plane_m = std::min(clearance.plane_m, distance.d_m - point.r_m);
  }
  const double eta = c.config.eta_1ps;
  const RowMaker::Pair pair{kind, index, plane.id, distance.d_m - d_safe_m, eta, point.buffer_mps};
  if (pair.spare_m <= c.config.consider_m) {
    const Vector3d& gradient_W = distance.gradient_W;
    VelocityCone cone;
    if (distance.on_face()) {  // the usual case
      cone = PlaneCone(plane, point.p_W, eta);
      if (base != nullptr) {
        AddStateVariance(WithBase(point.spread, *base, point.J), gradient_W, eta, cone);
      }
    } else {
      const Matrix3d B = SlabCurvature(plane, distance);
      cone = SlabCone(plane, point.p_W, gradient_W, B, eta);
      if (base != nullptr) {
        AddStateVariance(WithBase(point.spread, *base, point.J), gradient_W, B, eta, cone);
      }
    }
    maker.Chance(pair, gradient_W, point, cone);
  }
}

void AddPipe(const RowContext& c, int index, const PipeEstimate& pipe, const Matrix3d* base,
             const RobotPoint& point, RowMaker& maker, Clearances& clearance) {
  const AxisDistance distance = PointToPipeAxis(point.p_W, pipe, c.config.pipe_inflation_m);
  const double to_surface_m = distance.to_axis.d_m - pipe.radius_m;
  clearance.pipe_m = std::min(clearance.pipe_m, to_surface_m - point.r_m);
  const double d_safe_m = std::max(c.config.d_safe_pipe_m, point.r_m + c.config.margin_m);
  const double eta = c.config.eta_1ps;
  const RowMaker::Pair pair{RowKind::kPipe,          index, pipe.id,
                            to_surface_m - d_safe_m, eta,   point.buffer_mps};
  if (pair.spare_m <= c.config.consider_m) {
    VelocityCone cone = PipeCone(pipe, distance, eta);
    const Vector3d& gradient_W = distance.to_axis.gradient_W;
    if (base != nullptr) {
      AddStateVariance(WithBase(point.spread, *base, point.J), gradient_W,
                       PipeCurvature(pipe, distance), eta, cone);
    }
    maker.Chance(pair, gradient_W, point, cone);
  }
}

void AddObstacle(const RowContext& c, RowKind kind, int index, std::uint32_t which,
                 const PointDistance& distance, const RobotPoint& point, RowMaker& maker) {
  const double eta = c.config.eta_voxel_1ps;
  const double spare_m = distance.d_m - point.r_m - c.config.voxel_margin_m;
  const RowMaker::Pair pair{kind, index, which, spare_m, eta, point.buffer_mps};
  if (distance.d_m < kInside_m) {
    maker.Creep(pair, point);
  } else if (eta * spare_m <= c.config.eta_1ps * c.config.consider_m) {
    const Matrix3d B = BoxCurvature(distance);
    VelocityCone cone = VoxelCone(B, c.config.voxel_noise_m, eta);
    if (c.covariance_q != nullptr) {
      const PointSpread spread = WithBase(point.spread, c.covariance_q->base, point.J);
      if (B.isZero(0)) {  // a face, the usual case
        AddStateVariance(spread, distance.gradient_W, eta, cone);
      } else {
        AddStateVariance(spread, distance.gradient_W, B, eta, cone);
      }
    }
    maker.Chance(pair, distance.gradient_W, point, cone);
  }
}

/// One row for the obstacle that is nearest to the point, one for that nearest to where it is
/// heading: in a corner the second takes over only when it is as near as the first.
template <typename Find>
void AddObstacles(const RowContext& c, RowKind kind, int index, const RobotPoint& point,
                  const Find& find, RowMaker& maker, Clearances& clearance) {
  const Nearest nearest = find(point.p_W);
  if (nearest.any) {
    clearance.obstacle_m = std::min(clearance.obstacle_m, nearest.distance_m - point.r_m);
    AddObstacle(c, kind, index, 0, {nearest.distance_m, nearest.direction_W}, point, maker);
    if (nearest.distance_m < kInside_m) {
      return;
    }
  }
  const Vector3d ahead_W = c.config.ahead_s * (point.J * c.u_sent);
  if (ahead_W.squaredNorm() < kSamePoint_m * kSamePoint_m) {
    return;
  }
  const Nearest next = find(point.p_W + ahead_W);
  if (!next.any || (next.p_W - nearest.p_W).squaredNorm() < kSamePoint_m * kSamePoint_m) {
    return;
  }
  Vector3d p_WT = point.p_W;
  if (kind == RowKind::kColumn) {
    p_WT.z() = 0;  // columns have no height
  }
  AddObstacle(c, kind, index, 1, PointToPoint(p_WT, next.p_W), point, maker);
}

}  // namespace

void AddWorldRows(const RowContext& c, const Scene& scene, const DistanceField& field,
                  RowMaker& maker, Clearances& clearance) {
  const auto voxel = [&field](const Vector3d& p_W) { return field.NearestObstacle(p_W); };
  const auto column = [&field](const Vector3d& p_W) {
    return field.NearestColumn(p_W.x(), p_W.y());
  };
  const StateCovariance* unsure = c.covariance_q;
  const auto to_plane = [unsure](int i) { return unsure ? &unsure->ToPlane(i) : nullptr; };
  const auto to_pipe = [unsure](int i) { return unsure ? &unsure->ToPipe(i) : nullptr; };
  int index = 0;
  for (const BodySphere& sphere : c.shapes.spheres) {
    const RobotPoint point = MakePoint(c, sphere.body, sphere.p_L, sphere.r_m);
    const double d_safe_m = std::max(c.config.d_safe_plane_m, sphere.r_m + c.config.margin_m);
    for (int i = 0; i < scene.planes.size(); ++i) {
      AddPlane(c, RowKind::kPlane, index, scene.planes[i], to_plane(i), d_safe_m, point, maker,
               clearance);
    }
    for (int i = 0; i < scene.pipes.size(); ++i) {
      AddPipe(c, index, scene.pipes[i], to_pipe(i), point, maker, clearance);
    }
    AddObstacles(c, RowKind::kVoxel, index, point, voxel, maker, clearance);
    ++index;
  }
  for (const BaseDisc& disc : c.shapes.discs) {
    const RobotPoint point = MakePoint(c, 0, {disc.p_B.x(), disc.p_B.y(), 0}, disc.r_m);
    AddObstacles(c, RowKind::kColumn, index, point, column, maker, clearance);
    ++index;
  }
  const RobotPoint center = MakePoint(c, 0, {0, 0, kBaseHeight_m}, 0);
  for (int i = 0; i < scene.planes.size(); ++i) {
    if (std::abs(scene.planes[i].n_W.z()) < c.config.near_vertical_nz) {
      AddPlane(c, RowKind::kBasePlane, index, scene.planes[i], to_plane(i),
               c.config.d_safe_base_plane_m, center, maker, clearance);
    }
  }
}

}  // namespace pipewright
