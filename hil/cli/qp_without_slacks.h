// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "ctrl/qp/qp.h"
#include "hil/qpb/kkt.h"
#include "hil/qpb/qpb.h"

namespace pipewright::hil {

/// The file's problem with its slack variables dropped. The file prices a slack at 1/2 H_ss s^2, a
/// QpProblem at price s^2: price = H_ss / 2. Equalities come first, so row me + i is row i of Ai.
/// Variables beyond the file's stand in no row, cost 1/2 x_j^2 and have no bounds: exactly 0.
/// False when n variables and m rows are too few.
template <int n, int m>
bool WithoutSlacks(const QpbProblem& from, QpProblem<n, m>& to) {
  const int kept = from.kept();
  if (kept > n || from.equalities() + from.inequalities() > m) {
    return false;
  }
  to = {};
  for (int i = 0; i < kept; ++i) {
    for (int j = 0; j < kept; ++j) {
      to.H(i, j) = from.H[i * from.n + j];
    }
    to.g[i] = from.g[i];
    to.lb[i] = from.lb[i];
    to.ub[i] = from.ub[i];
  }
  const auto row = [&](const std::vector<double>& A, int i) {
    Vec<n> a = Vec<n>::Zero();
    for (int j = 0; j < kept; ++j) {
      a[j] = A[i * from.n + j];
    }
    return a;
  };
  bool fits = true;
  for (int i = 0; i < from.equalities(); ++i) {
    fits = to.AddRow(row(from.Ae, i), from.be[i], from.be[i]) && fits;
  }
  for (int i = 0; i < from.inequalities(); ++i) {
    fits = to.AddRow(row(from.Ai, i), from.l[i], from.u[i]) && fits;
  }
  for (int k = 0; k < from.slacks(); ++k) {
    const int i = from.soft_row[k];
    const int s = kept + k;
    const bool crossed = from.l[i] > from.u[i];  // no slack helps: as infeasible as a hard row
    to.price[from.equalities() + i] = crossed ? 0 : from.H[s * from.n + s] / 2;
  }
  return fits;
}

/// By how much a_i'x is above u_i, or below l_i (< 0), without the slack of that row.
inline double MissedBy(const QpbProblem& p, int i, const std::vector<double>& x) {
  double y = 0;
  for (int j = 0; j < p.kept(); ++j) {
    y += p.Ai[i * p.n + j] * x[j];
  }
  return y > p.u[i] ? y - p.u[i] : y < p.l[i] ? y - p.l[i] : 0;
}

/// A solution of WithoutSlacks(p) in the file's variables. A slack's own stationarity is
/// H_ss s = lambda, which gives s without rounding however high its price; where no optimum is
/// claimed, hence no lambda, s is what its row misses by.
template <int n, int m>
QpbPoint WithSlacks(const QpbProblem& p, const QpSolution<n, m>& solution) {
  const auto first = [](const auto& v, int from, int count) {
    return std::vector<double>(v.data() + from, v.data() + from + count);
  };
  QpbPoint at;
  at.x = first(solution.x, 0, p.kept());
  at.nu = first(solution.lambda_rows, 0, p.equalities());
  at.lambda = first(solution.lambda_rows, p.equalities(), p.inequalities());
  at.mu = first(solution.lambda_box, 0, p.kept());
  at.mu.resize(static_cast<std::size_t>(p.n), 0.0);
  for (int k = 0; k < p.slacks(); ++k) {
    const int i = p.soft_row[k];
    const int s = p.kept() + k;
    at.x.push_back(solution.status == QpStatus::kOptimal ? at.lambda[i] / p.H[s * p.n + s]
                                                         : MissedBy(p, i, at.x));
  }
  return at;
}

}  // namespace pipewright::hil
