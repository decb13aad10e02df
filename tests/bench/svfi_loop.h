// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ctrl/whole_body/whole_body_controller.h"
#include "platform/core/rng.h"

namespace pipewright::bench {

enum class Primitive : std::uint8_t { kPlane, kPipe, kPipeEnd, kVoxel };

/// What is measured in one go: a primitive, a probability, a way to meet it.
struct Cell {
  Primitive primitive = Primitive::kPlane;
  bool unsure = false;  ///< q is uncertain, too: UnsureState
  bool joint = false;   ///< alpha is of all rows of the cycle together
  double alpha = 0.7;
  SvfiMode mode = SvfiMode::kExact;
};

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

/// A cycle in which a chance row was leaned on for the u that was sent.
struct Instance {
  std::unique_ptr<WholeBodyController> before;  ///< as it was when the cycle began
  RobotState state;
  Goal goal;
  Surface estimate;
  Time now{};

  bool unsure = false;
  std::vector<int> points;  ///< of the robot: its spheres, its discs, one past them the base
  Controls u;               ///< that was sent
  double buffer_mps = 0;    ///< what the row keeps beyond the VFI: b - limit
};

/// Means and extremes over all leaned-on cycles of one kind.
struct Leaned {
  long cycles = 0;
  double margin_sum = 0;  ///< (b - a'u)/sigma_f(u) - z
  double margin_min = 1e9;
  double slack_sum_mps = 0;      ///< b - a'u - z sigma_f(u)
  double row_margin_min = 1e9;   ///< with the row's limit in place of b
  std::vector<Instance> sample;  ///< drawn without preference
};

struct LoopResult {
  Leaned rising;  ///< sigma_f(u) exceeds that of the u before by 1 % or more
  Leaned rest;
  Instance worst;    ///< the cycle with the least margin of all
  long clamped = 0;  ///< leaned-on cycles where even standing still has less than alpha
  int episodes = 0;
  int episodes_kept = 0;      ///< the true surface was never nearer than d_safe
  double penetration_mm = 0;  ///< of d_safe by the robot's points, worst
};

inline constexpr double kInflation_m = ConstraintConfig{}.pipe_inflation_m;

double EtaOf(Primitive primitive);
/// Distance that the true surface must keep from a robot point.
double SafeOf(Primitive primitive, int point);

WholeBodyConfig ConfigOf(const Cell& cell);
/// 3 mm and 3 mrad of the base, 1 mrad of each joint, each alone.
const StateCovariance& UnsureState();
/// q as it might truly be.
Configuration DrawState(const Configuration& q, Rng& rng);

/// p_WT of a robot point at configuration q, and its Jacobian.
Vector3d PointAt(const Configuration& q, int point);
Mat<3, kControls> JacobianAt(const Configuration& q, int point);

/// Drives the real controller towards set points beyond a surface it is near to, with the
/// estimate's covariance and a truth drawn from it, and keeps `keep` cycles of each kind.
LoopResult RunLoops(const Cell& cell, int episodes, int keep, std::uint64_t seed);

}  // namespace pipewright::bench
