// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ctrl/whole_body/whole_body_controller.h"
#include "platform/core/rng.h"

namespace pipewright::bench {

enum class Primitive : std::uint8_t { kPlane, kPipe, kPipeEnd };

/// What is measured in one go: a primitive, a probability, a way to meet it.
struct Cell {
  Primitive primitive = Primitive::kPlane;
  double alpha = 0.7;
  SvfiMode mode = SvfiMode::kExact;
};

/// A primitive by what it is drawn from: a plane through p with normal `axis`, or a pipe about the
/// axis through p. sigma_m is of the offset across (a pipe's radius: half), sigma_rad of the tilt
/// about p.
struct Surface {
  Primitive kind = Primitive::kPlane;
  Vector3d p = Vector3d::Zero();
  Vector3d axis = Vector3d::UnitZ();
  double radius_m = 0;
  double half_m = 5;
  double sigma_m = 0;
  double sigma_rad = 0;

  Scene ToScene() const;
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

  int point = 0;          ///< of the robot: index of its sphere, or one past all points: the base
  Vector3d t;             ///< it, in W
  Vector3d v;             ///< J_t u
  double safe_m = 0;      ///< distance that the true surface must keep from t
  double buffer_mps = 0;  ///< what the row keeps beyond the VFI: b - limit
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
inline constexpr double kEta_1ps = ConstraintConfig{}.eta_1ps;

WholeBodyConfig ConfigOf(const Cell& cell);

/// p_WT of an Instance's point at configuration q.
Vector3d PointAt(const Configuration& q, int point);

/// Drives the real controller towards set points beyond a surface it is near to, with the
/// estimate's covariance and a truth drawn from it, and keeps `keep` cycles of each kind.
LoopResult RunLoops(const Cell& cell, int episodes, int keep, std::uint64_t seed);

}  // namespace pipewright::bench
