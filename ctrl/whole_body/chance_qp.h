// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/constraints/constraint_set.h"
#include "ctrl/qp/qp.h"

namespace pipewright {

/// Cost of law (3) in u: ½ u'H u + g'u.
struct QuadraticCost {
  Mat<kControls, kControls> H = Mat<kControls, kControls>::Identity();
  Controls g = Controls::Zero();
};

struct ChanceQpStats {
  bool optimal = false;  ///< every QP of the cycle was solved to its end
  bool infeasible = false;
  int rounds = 0;      ///< QPs solved
  int iterations = 0;  ///< of all rounds
  int cap_hits = 0;
  int fallbacks = 0;  ///< rows that went to worst_case because the rounds ran out
  double scaled = 1;  ///< part of the answer that was sent: 1 unless it had to be shortened
  int checked = 0;    ///< hard chance rows looked at, for the u that is sent
  int held = 0;       ///< of them, a'u + z σ_f(u) ≤ b + 1e-6
};

/// A QP with stochastic rows.
///
/// kExact: the cones are replaced by their tangents at the last u and the QP is solved again
/// until every cone holds to 1e-6 (tangents lie below a convex σ_f, so a fixed point is the
/// optimum of the cone program). When the rounds run out, the rows still violated go to their
/// worst case. Last, since u = 0 keeps every hard row and the set is convex, u is shortened until
/// each hard cone holds.
class ChanceQp {
 public:
  explicit ChanceQp(int max_rounds) : max_rounds_(max_rounds) {}

  struct Answer {
    Controls u = Controls::Zero();  ///< keeps all hard rows; 0 when nothing else does
    ChanceQpStats stats;
  };
  /// `u0`: where the first tangents are taken, and σ_f frozen in kPreviousVelocity.
  Answer Solve(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
               const Controls& u0);

 private:
  int max_rounds_;
};

}  // namespace pipewright
