// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "ctrl/constraints/config.h"
#include "ctrl/constraints/svfi.h"
#include "perception/map/distance_field.h"
#include "perception/scene.h"
#include "platform/core/rng.h"
#include "platform/robot/robot.h"

namespace pipewright::bench {

enum class Primitive : std::uint8_t { kPlane, kPipe, kPipeEnd, kVoxel };

/// A primitive by what it is drawn from: a plane through p with normal `axis`, a pipe about the
/// axis through p, or a post of obstacle voxels as high as the map, 2 half_m wide, about the
/// vertical through p. sigma_m is of the offset across (a pipe's radius: half), sigma_rad of the
/// tilt about p.
struct Surface {
  Primitive kind = Primitive::kPlane;
  Vector3d p = Vector3d::Zero();
  Vector3d axis = Vector3d::UnitZ();
  double radius_m = 0;
  double half_m = 5;
  double sigma_m = 0;
  double sigma_rad = 0;

  Scene ToScene() const;
  /// What the controller holds of obstacles: a post, or nothing.
  const DistanceField& Field() const;
  /// Another one, drawn from the normal about this one on the manifold: |axis| = 1.
  Surface Draw(Rng& rng) const;
};

inline constexpr double kVoxel_m = 0.05;
inline constexpr double kPostAt_m = 0.5;  ///< a post's corner, on the grid
inline constexpr int kPosts = 4;          ///< by their width in voxels

inline constexpr double kInflation_m = ConstraintConfig{}.pipe_inflation_m;

double EtaOf(Primitive primitive);
/// Distance that the true surface must keep from a robot point.
double SafeOf(Primitive primitive, int point);

/// 3 mm and 3 mrad of the base, 1 mrad of each joint, each alone.
const StateCovariance& UnsureState();
/// q as it might truly be.
Configuration DrawState(const Configuration& q, Rng& rng);

/// Robot points by number: the spheres, then the discs, then the base's centre.
int BasePoint();
/// p_WT of a robot point at configuration q, and its Jacobian.
Vector3d PointAt(const Configuration& q, int point);
Mat<3, kControls> JacobianAt(const Configuration& q, int point);

}  // namespace pipewright::bench
