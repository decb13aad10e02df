// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ctrl/whole_body/whole_body_controller.h"
#include "tests/bench/svfi_surface.h"

namespace pipewright::bench {

/// What is measured in one go: a primitive, a probability, a way to meet it.
struct Cell {
  Primitive primitive = Primitive::kPlane;
  bool unsure = false;  ///< q is uncertain, too: UnsureState
  bool joint = false;   ///< alpha is of all rows of the cycle together
  double alpha = 0.7;
  SvfiMode mode = SvfiMode::kExact;
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

WholeBodyConfig ConfigOf(const Cell& cell);
/// Drives the real controller towards set points beyond a surface it is near to, with the
/// estimate's covariance and a truth drawn from it, and keeps `keep` cycles of each kind.
LoopResult RunLoops(const Cell& cell, int episodes, int keep, std::uint64_t seed);

}  // namespace pipewright::bench
