// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/constraints/constraint_set.h"
#include "ctrl/qp/dual_active_set.h"

namespace pipewright {

/// Cost of law (3) in u: ½ u'H u + g'u.
struct QuadraticCost {
  Mat<kControls, kControls> H = Mat<kControls, kControls>::Identity();
  Controls g = Controls::Zero();
};

struct ChanceQpStats {
  QpStatus status = QpStatus::kOptimal;  ///< the worst of the cycle's QPs
  int rounds = 0;                        ///< QPs solved
  int iterations = 0;                    ///< of all of them
  int fallbacks = 0;  ///< rows that went to their worst case because the rounds ran out
  double scale = 1;   ///< part of the QP's answer that is sent: 1 unless it had to be shortened
  int checked = 0;    ///< hard chance rows, for the u that is sent
  int held = 0;       ///< of them, those with a'u + z σ_f(u) ≤ b + 1e-6
  int soft_checked = 0;
  int soft_held = 0;
  bool out_of_reach = false;  ///< no u that the robot can brake to keeps every row
};

/// A QP with stochastic rows.
///
/// kExact: the cones are replaced by their tangents at the last u. A tangent lies below the convex
/// σ_f, so that QP is a relaxation, and if its answer meets the cones to 1e-6 it is the optimum:
/// the usual case. Otherwise more QPs follow, each with the tangents at the last answer besides the
/// old ones (Kelley's cutting planes: the set closes in) and with the curvature λ_i z J'∇²σ_f J of
/// the rows leaned on in H (Newton's step: few rounds), until the cones are met and u stands. A
/// soft cone has one tangent at a time, for each would be charged. Measured: 3 to 7 rounds, 10 at
/// most, on random problems from a cold start. When the rounds run out, the rows still violated go
/// to their worst case. Last, since u = 0 keeps every hard row and the set is convex, u is
/// shortened until each hard cone holds.
///
/// The cycle's QPs share kMaxIterations, of which each takes what it needs: the first after nothing
/// was near, in a place that is inside of everything, has a hundred soft rows to add and more. One
/// that finds them used up stops the robot.
///
/// The box is first that part of it that the robot can reach in one period, so that the envelope
/// lets u through as it is. Only when nothing there keeps the rows is it the whole, in which u = 0
/// lies: then u says how to brake.
class ChanceQp {
 public:
  static constexpr double kConeTolerance_mps = 1e-6;
  static constexpr double kStepTolerance = 1e-4;  ///< of a Newton step, whose error is its square

  static constexpr int kMaxIterations = 500;  ///< of all QPs of a cycle; in missions 30 are rare

  /// At most max_rounds QPs a cycle, and one more with rows at their worst case.
  explicit ChanceQp(int max_rounds) : max_rounds_(max_rounds) {}

  struct Answer {
    Controls u = Controls::Zero();  ///< keeps all hard rows; 0 when nothing else does
    ChanceQpStats stats;
  };
  /// Counts anew how many rows of `set` hold, for a u that is sent in place of the answer's.
  static void Count(const ConstraintSet& set, const Controls& u, ChanceQpStats& stats);

  /// `u0`: where the first tangents are taken, and where kPreviousVelocity freezes σ_f.
  Answer Solve(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
               const Controls& u0);

 private:
  bool SolveInReach(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
                    const Controls& u0, Answer& answer);
  void SolveInBox(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
                  const Controls& u0, Answer& answer);
  bool MeetCones(const QuadraticCost& cost, const ConstraintSet& set, int max_rounds,
                 Answer& answer);
  void Pose(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode, const Controls& u0);
  const Vec<kMaxRows>& SolveOnce(Answer& answer);  ///< multipliers of the rows
  void Evaluate(const ConstraintSet& set, const Controls& u);
  bool Meets(const ConstraintSet& set, const Controls& u) const;
  void PoseAbout(const QuadraticCost& cost, const ConstraintSet& set, const Controls& u,
                 const Vec<kMaxRows>& lambda);
  int FallBack(const ConstraintSet& set);
  void Shorten(const ConstraintSet& set, Answer& answer);
  static void CountRow(const ChanceRow& row, double excess_mps, ChanceQpStats& stats);
  void SetRow(int i, const Row& row);

  int max_rounds_;
  int cone_[kMaxRows] = {};             ///< the chance row that a row of the QP is a cut of
  int first_chance_ = 0;                ///< row of the first chance row
  double excess_[kMaxChanceRows] = {};  ///< ChanceExcess of each chance row at the last answer
  QpProblem<kControls, kMaxRows> qp_;
  QpSolver<kControls, kMaxRows> solver_;
};

}  // namespace pipewright
