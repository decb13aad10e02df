// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/constraints/constraint_set.h"
#include "perception/map/distance_field.h"
#include "perception/map/voxel_grid.h"
#include "platform/core/rng.h"
#include "platform/robot/uf7.h"

namespace pipewright::test {

inline Vector3d RandomDirection(Rng& rng) {
  Vector3d v;
  do {
    v = Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
  } while (v.norm() < 1e-3);
  return v.normalized();
}

inline Vector3d RandomIn(Rng& rng, const Vector3d& lo, const Vector3d& hi) {
  return {rng.Uniform(lo.x(), hi.x()), rng.Uniform(lo.y(), hi.y()), rng.Uniform(lo.z(), hi.z())};
}

template <int n>
Mat<n, n> RandomCovariance(Rng& rng, double sigma) {
  Mat<n, n> L;
  for (int i = 0; i < n * n; ++i) {
    L(i) = sigma * rng.Normal() / std::sqrt(n);
  }
  return L * L.transpose();
}

inline Configuration RandomConfiguration(Rng& rng) {
  Configuration q;
  q << rng.Uniform(-0.2, 0.2), rng.Uniform(-0.2, 0.2), rng.Uniform(-3, 3), ArmVector::Zero();
  for (int j = 0; j < kArmJoints; ++j) {
    const ArmJoint& joint = TracerUf7().arm.joints[j];
    q(3 + j) = rng.Uniform(std::max(joint.q_min_rad, -2.0), std::min(joint.q_max_rad, 2.0));
  }
  return q;
}

inline Configuration HomeConfiguration() {
  Configuration q = Configuration::Zero();
  q.tail<kArmJoints>() = HomeJoints(TracerUf7());
  return q;
}

/// A plane through p with its rectangle around it; the covariance's null space is n's own
/// direction.
inline PlaneEstimate MakePlane(std::uint32_t id, const Vector3d& p, const Vector3d& n,
                               double half_m, double sigma_n, double sigma_d) {
  PlaneEstimate plane;
  plane.id = id;
  plane.n_W = n;
  plane.d_m = n.dot(p);
  plane.p_WCentroid = p;
  plane.e1_W = n.unitOrthogonal();
  plane.e2_W = n.cross(plane.e1_W);
  for (int i = 0; i < 2; ++i) {
    plane.extent_lo_m[i] = -half_m;
    plane.extent_hi_m[i] = half_m;
  }
  Mat<4, 3> A = Mat<4, 3>::Zero();  // of (turn about e2, turn about e1, shift) about p
  A.block<3, 1>(0, 0) = plane.e1_W * sigma_n;
  A.block<3, 1>(0, 1) = plane.e2_W * sigma_n;
  A.row(3) << plane.e1_W.dot(p) * sigma_n, plane.e2_W.dot(p) * sigma_n, sigma_d;
  plane.covariance = A * A.transpose();
  return plane;
}

inline PipeEstimate MakePipe(std::uint32_t id, const Vector3d& p, const Vector3d& l, double r_m,
                             double half_m, double sigma_m, double sigma_l) {
  PipeEstimate pipe;
  pipe.id = id;
  pipe.p_W = p;
  pipe.l_W = l;
  pipe.radius_m = r_m;
  pipe.extent_lo_m = -half_m;
  pipe.extent_hi_m = half_m;
  const Matrix3d across = Matrix3d::Identity() - l * l.transpose();
  pipe.covariance.topLeftCorner<3, 3>() = sigma_m * sigma_m * across;
  pipe.covariance.block<3, 3>(3, 3) = sigma_l * sigma_l * across;
  pipe.covariance(6, 6) = sigma_m * sigma_m / 4;
  return pipe;
}

/// Voxels about the robot: everything known to be free but the balls of obstacle voxels asked for.
class VoxelWorld {
 public:
  VoxelWorld() : grid_(Config()), field_(Config()) {
    grid_.MarkSweptSphere(Vector3d::Zero(), 3);
    field_.Update(grid_);
  }
  void AddObstacle(const Vector3d& p_W) {
    const Vector3f p = p_W.cast<float>();
    grid_.InsertScan(&p, 1, p, -1);
  }
  void Update() { field_.Update(grid_); }
  const VoxelGrid& grid() const { return grid_; }
  const DistanceField& field() const { return field_; }

 private:
  static MapConfig Config() {
    MapConfig config;
    config.lo = config.workspace_lo = {-30, -30, -2};
    config.hi = config.workspace_hi = {29, 29, 29};
    config.brick_capacity = BricksOfBox(config);
    return config;
  }
  VoxelGrid grid_;
  DistanceField field_;
};

}  // namespace pipewright::test
