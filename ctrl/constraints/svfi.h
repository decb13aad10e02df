// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/constraints/config.h"
#include "ctrl/constraints/distance.h"
#include "perception/plane_slab.h"
#include "platform/core/status.h"

namespace pipewright {

/// What is known of how wrong the robot's q may be: base (x, y, φ) in W, and each joint alone. A
/// base's error is against what was placed in W by its pose at the time: against the map it is
/// `base`, against a primitive that was last seen earlier it is more.
struct StateCovariance {
  Matrix3d base = Matrix3d::Zero();                   ///< m², m rad, rad²
  ArmVector joint_rad2 = ArmVector::Zero();           ///< variances
  FixedVector<Matrix3d, Scene::kMaxPlanes> to_plane;  ///< as `base`, in the scene's order
  FixedVector<Matrix3d, Scene::kMaxPipes> to_pipe;

  const Matrix3d& ToPlane(int i) const { return i < to_plane.size() ? to_plane[i] : base; }
  const Matrix3d& ToPipe(int i) const { return i < to_pipe.size() ? to_pipe[i] : base; }
};

/// Variance of f = ∇d' J_t u + η (d − d_safe) under the primitive's covariance Σ, as a function of
/// the point's velocity v = J_t u:
///
///   ∇f(v) = K v + h,    σ_f² = ∇f' Σ ∇f = v'Qv + 2 q'v + c                    [CFNBV] (13), (14)
///   Q = K'ΣK (3×3),  q = K'Σh,  c = h'Σh
///
/// σ_f = ‖L'(K J_t u + h)‖ with Σ = LL': convex in u.
struct VelocityCone {
  Matrix3d Q = Matrix3d::Zero();
  Vector3d q = Vector3d::Zero();
  double c = 0;

  double Sigma(const Vector3d& v_WT) const;
  /// ∂σ_f/∂v; zero where σ_f is zero (there a subgradient).
  Vector3d Gradient(const Vector3d& v_WT) const;
  /// ∂²σ_f/∂v² = (Q − gg')/σ_f with g the gradient: positive semidefinite.
  Matrix3d Curvature(const Vector3d& v_WT) const;
  /// Upper bound of σ_f over |v_i − center_i| ≤ radius_i:  σ_f(center) + (Σ|Q_ij| r_i r_j)^½
  double UpperBound(const Vector3d& center, const Vector3d& radius) const;
};

/// Plane: θ = (n, d_π), K = [I; 0], h = η [t; −1]. With the whole 4×4 Σ, σ_f does not depend on the
/// frame's origin: moving it by o changes t to t − o, d_π to d_π − n'o, and Σ with them.
VelocityCone PlaneCone(const PlaneEstimate& plane, const Vector3d& p_WT, double eta_1ps);

/// The plane's slab, which moves with (n, d_π) as a rigid body about the rectangle's centroid c,
/// its turn about n left out. Its points move by δ(x) = n (∂d_π − x'∂n) + n'(x − c) ∂n at x, t's
/// distance by −e'δ(t), e = ∇d; and e turns by (n × ∂n) × e − B δ(t):
///
///   ∂f = (n'e)(v'∂n) − (n'v)(e'∂n) − δ(t)'(B v + η e)
///
/// On the face, e = n and B = 0, that is PlaneCone's: along n, ∂n has no part. Where the rectangle
/// ends is not in Σ: the inflation has to hold it.
VelocityCone SlabCone(const PlaneEstimate& plane, const Vector3d& p_WT, const Vector3d& gradient_W,
                      const Matrix3d& B, double eta_1ps);

/// B = ∂²d/∂t² of the distance to a plane's slab: BoxCurvature along its own axes.
Matrix3d SlabCurvature(const PlaneEstimate& plane, const SlabDistance& distance);

/// Pipe: θ = (p, l, r), first order in θ. With w = t − p, ρ the distance to the axis,
/// e = ∇d, m = l × e:
///   ∂d/∂θ       = [−e; −(l'w) e; −1]
///   ∂(e'v)/∂p   = −(m'v) m / ρ
///   ∂(e'v)/∂l   = −(l'w)(m'v) m / ρ − (l'v) e        (l moves across itself only)
/// At an end, s fixed: ∂d/∂θ = [−e; −s e; −1], ∂(e'v)/∂p = −(I − ee')v/ρ, ∂(e'v)/∂l = s times that.
/// Both are of δ = ∂p + s ∂l, how the axis moves at s, with B of PipeCurvature:
///   ∂f = −(B v + η e)'δ − (l'v) e'∂l − η ∂r      (at an end without the second term)
VelocityCone PipeCone(const PipeEstimate& pipe, const AxisDistance& distance, double eta_1ps);

/// Obstacle voxel: θ = the place of its box, known with covariance σ² I. The box moves as a whole,
/// so that the rate changes with it by the curvature of the distance alone (BoxCurvature):
///   ∂d/∂θ = −e,  ∂(e'v)/∂θ = −B v:   σ_f² = σ² (|B v|² + η²),   for B e = 0
VelocityCone VoxelCone(const Matrix3d& B, double sigma_m, double eta_1ps);

/// What the robot does not know of the place of one of its points t and of its heading φ.
struct PointSpread {
  Matrix3d t = Matrix3d::Zero();      ///< J_q Σ J_q' [m²]
  Vector3d t_phi = Vector3d::Zero();  ///< covariance of t and φ [m rad]
  double phi = 0;                     ///< [rad²]
};

/// By the joints alone. J is the point's J_t on the reduced controls. Some 60 multiply-adds.
PointSpread SpreadOf(const ArmVector& joint_rad2, const Mat<3, kControls>& J);

/// And by the base, whose error is independent of theirs. J's column 1 is ∂t/∂φ. Some 30
/// multiply-adds: for each primitive anew.
PointSpread WithBase(const PointSpread& of_joints, const Matrix3d& base,
                     const Mat<3, kControls>& J);

/// Adds to `cone` what the robot does not know of itself: ∇f' Σ ∇f over q = (x, y, φ, q1 ... q7).
/// q moves the point, ∂t = J_q ∂q, and d is a function of t − θ's place only:
///
///   ∂f/∂q = J_q' ∂f/∂t + (0, 0, 1, 0 ... 0)' w'v,    w = ∇d × z
///   ∂f/∂t = B v + η ∇d,   B = ∂²d/∂t²
///   B = 0 (a plane's face),  mm'/ρ (line, m = l × e),  (I − ee')/ρ (point),
///       BoxCurvature (voxel), SlabCurvature (a plane's border)
///
/// (∂f/∂t)'Σ_t(∂f/∂t) with Σ_t = J_q Σ J_q', which [CFNBV] leaves open, and one term more: v turns
/// with the base's heading (z is up), so that an error of the base's pose is whole to first order.
/// For the joints J_t counts as known: their ∂(J_t u)/∂q_j is left out, at most |∂q_j| |ω| |t −
/// o_j| where η |∂q_j| |t − o_j| is counted: small while the arm turns slower than η.
///
/// Independent of the primitive's own Σ. With a zero spread `cone` keeps its bits.
void AddStateVariance(const PointSpread& spread, const Vector3d& gradient_W, const Matrix3d& B,
                      double eta_1ps, VelocityCone& cone);
/// The same where B is zero.
void AddStateVariance(const PointSpread& spread, const Vector3d& gradient_W, double eta_1ps,
                      VelocityCone& cone);

/// B = ∂²d/∂t² of the distance to a box along W's axes: a face is flat, an edge bends as a line, a
/// corner as a point:
///   B = (S − ee')/d,   S diagonal, S_ii = 1 where e_i ≠ 0
Matrix3d BoxCurvature(const PointDistance& distance);

/// B = ∂²d/∂t² of the distance to a pipe's axis or, at its end, to that point.
Matrix3d PipeCurvature(const PipeEstimate& pipe, const AxisDistance& distance);

/// One stochastic VFI on u: the VFI holds with probability at least α,
///
///   a'u + z σ_f(J_t u) ≤ b,   a = −J_t'∇d,  b = η (d − d_safe),  z = Φ⁻¹(α)       [CFNBV] (16)
///
/// `limit` is b, raised to z σ_f(0) when a hard row would not even let the robot stand still: then
/// it may not come nearer, and `b` stays what the chance constraint asks.
struct ChanceRow {
  Controls a = Controls::Zero();
  double b = 0;
  double limit = 0;
  double price = 0;
  int key = 0;
  VelocityCone cone;
  Mat<3, kControls> J = Mat<3, kControls>::Zero();  ///< J_t of the robot point
};

using ChanceRowSet = FixedVector<ChanceRow, kMaxChanceRows>;

/// z = Φ⁻¹(α); kOutOfRange unless 0.5 ≤ α < 1: below a half the constraint is not convex.
Result<double> ChanceQuantile(double alpha);

/// The z of each of `rows` rows that are to hold together with probability α, whatever the
/// dependence between them. By Boole's inequality the risks add up at most:
///
///   P(any fails) ≤ Σ (1 − α_i) = 1 − α   with   α_i = 1 − (1 − α)/rows,   z = −Φ⁻¹((1 − α)/rows)
///
/// In equal parts; [BO11] bounds a joint risk in this way. None or one row: ChanceQuantile(α).
///
/// [BO11] Blackmore, Ono, Williams: Chance-constrained optimal path planning with obstacles,
///        IEEE Trans. Robotics 27(6), 2011.
Result<double> JointChanceQuantile(double alpha, int rows);

/// a'u + z σ_f(J u) − limit: how much row is violated at u, negative when it holds.
double ChanceExcess(const ChanceRow& row, const Controls& u, double z);

/// The tangent of the cone at u0, a linear row that every u within the cone keeps.
Row TangentCut(const ChanceRow& row, const Controls& u0, double z);

/// The row with σ_f frozen at u0: the published surrogate.
Row FrozenRow(const ChanceRow& row, const Controls& u0, double z);

/// The row with σ_f at its upper bound over lb ≤ u ≤ ub.
Row WorstCaseRow(const ChanceRow& row, const Controls& lb, const Controls& ub, double z);

}  // namespace pipewright
