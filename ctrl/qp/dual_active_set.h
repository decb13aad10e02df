// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/qp/qp.h"

namespace pipewright {

struct QpConfig {
  int max_iterations = 200;
  double feasibility_tol = 1e-10;  ///< of a row or bound at an optimum, in the row's unit
};

constexpr bool Valid(const QpConfig& c) { return c.max_iterations > 0 && c.feasibility_tol > 0; }

/// Solves QpProblems of one size, warm-started from the active set of the last solve.
template <int n, int m>
class QpSolver {
 public:
  explicit QpSolver(const QpConfig& config = {}) : config_(config) {}

  /// @param feasible  a point known to satisfy every hard row and the box (in control usually 0),
  ///                  or nullptr. When the solve is capped the answer lies between it and the
  ///                  last iterate, at the last point that satisfies every hard row.
  /// The result stays valid until the next call.
  const QpSolution<n, m>& Solve(const QpProblem<n, m>& qp, const Vec<n>* feasible = nullptr);

  /// The next solve starts from no active set.
  void ForgetActiveSet();

 private:
  QpConfig config_;
};

}  // namespace pipewright
