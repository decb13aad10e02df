// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/constraints/constraint_set.h"
#include "ctrl/constraints/row_selection.h"

namespace pipewright {

/// A point of the robot with all that rows need of it.
struct RobotPoint {
  Vector3d p_W = Vector3d::Zero();
  Mat<3, kControls> J = Mat<3, kControls>::Zero();  ///< v_WT = J u
  double r_m = 0;                                   ///< of the ball about it
  double buffer_mps = 0;                            ///< HoldBuffer of J
  PointSpread spread;                               ///< by the joints; zero when q is known
};

/// What a period of constant u can take from a distance beyond its rate at the start, per period:
/// ½ T |p''|. With joint j nearer to the base than i, ∂J_i/∂q_j = z_j × J_i, so
///
///   |p''| ≤ Σ_i |u_i| |J_i| (|ω_i| + 2 Σ_{j nearer} |ω_j|),   |u_i| ≤ u_max_i
///
/// Distances to convex things are convex in p: only p'' can shorten them further.
double HoldBuffer(const Mat<3, kControls>& J, const Controls& u_max, double period_s);

/// Turns distances into rows, and keeps those that bind first when they are too many.
class RowMaker {
 public:
  /// The box of `out` is to be there already.
  RowMaker(const ConstraintConfig& config, double z, ConstraintSet& out);

  struct Pair {
    RowKind kind;
    int first;
    std::uint32_t second;
    double spare_m;  ///< d − d_safe
    double eta_1ps;
    double buffer_mps;  ///< HoldBuffer
  };
  /// VFI (5): −g'u ≤ η (d − d_safe) − buffer, where d' = g'u.
  void Distance(const Pair& pair, const Controls& g);
  /// The same with probability α.
  void Chance(const Pair& pair, const Vector3d& gradient_W, const RobotPoint& point,
              const VelocityCone& cone);
  /// The point has no direction to leave in: each component of its velocity is slow.
  void Creep(const Pair& pair, const RobotPoint& point);
  void JointSpeed(int control, double speed_radps);

  /// Chance rows so far, those that did not fit among them.
  int chance_rows() const { return out_.chance.size() + chance_.dropped(); }

  /// Draws the box in to where the rows that were dropped hold, then appends the wishes to leave,
  /// as far as there is room. Call once, last.
  void Finish();

 private:
  void Leave(const Pair& pair, const Controls& g);

  const ConstraintConfig& config_;
  double z_;
  ConstraintSet& out_;
  RowSelection<Row, kMaxPlainRows> plain_;
  RowSelection<ChanceRow, kMaxChanceRows> chance_;
  FixedVector<Row, 24> leave_;
};

}  // namespace pipewright
