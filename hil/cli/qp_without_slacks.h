// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cfloat>
#include <optional>
#include <vector>

#include "ctrl/qp/qp.h"
#include "hil/qpb/kkt.h"
#include "hil/qpb/qpb.h"

namespace pipewright::hil {

/// A hard row of one variable alone, which is a bound of it: lo <= x_variable <= hi.
struct BoundRow {
  int variable;
  double a;
  double lo;
  double hi;
};

/// Row `row` of a file, Ae's rows before Ai's, when it is one. Not a crossed one: it
/// stays a row.
inline std::optional<BoundRow> AsBound(const QpbProblem& p, int row) {
  const int me = p.equalities();
  const double* const a = row < me ? &p.Ae[row * p.n] : &p.Ai[(row - me) * p.n];
  const double l = row < me ? p.be[row] : p.l[row - me];
  const double u = row < me ? p.be[row] : p.u[row - me];
  int variable = -1;
  for (int j = 0; j < p.n; ++j) {
    if (a[j] != 0) {
      if (variable >= 0) {
        return std::nullopt;
      }
      variable = j;
    }
  }
  if (variable < 0 || variable >= p.kept() || l > u) {
    return std::nullopt;
  }
  const double first = l / a[variable];
  const double second = u / a[variable];
  const BoundRow bound{variable, a[variable], std::min(first, second), std::max(first, second)};
  const bool overflown = bound.lo > DBL_MAX || bound.hi < -DBL_MAX;  // by a tiny coefficient
  return overflown ? std::nullopt : std::optional(bound);
}

/// The file's problem with its slack variables dropped, and the hard rows of a single variable
/// among the bounds. The file prices a slack at 1/2 H_ss s^2, a QpProblem at price s^2: price =
/// H_ss / 2. A row's key is its place in the file, Ae's rows first. Variables beyond the file's
/// stand in no row, cost 1/2 x_j^2 and have no bounds: exactly 0. False when n variables and m rows
/// are too few.
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
  std::vector<double> price(from.l.size(), 0.0);
  for (int k = 0; k < from.slacks(); ++k) {
    const int i = from.soft_row[k];
    const int s = kept + k;
    const bool crossed = from.l[i] > from.u[i];  // no slack helps: as infeasible as a hard row
    price[i] = crossed ? 0 : from.H[s * from.n + s] / 2;
  }
  const auto add = [&](const std::vector<double>& A, int i, int row, double lo, double hi,
                       double row_price) {
    if (const std::optional<BoundRow> bound = AsBound(from, row)) {
      to.lb[bound->variable] = std::max(to.lb[bound->variable], bound->lo);
      to.ub[bound->variable] = std::min(to.ub[bound->variable], bound->hi);
      return true;
    }
    Vec<n> a = Vec<n>::Zero();
    for (int j = 0; j < kept; ++j) {
      a[j] = A[i * from.n + j];
    }
    return to.AddRow(a, lo, hi, row_price, row);
  };
  bool fits = true;
  for (int i = 0; i < from.equalities(); ++i) {
    fits = add(from.Ae, i, i, from.be[i], from.be[i], 0) && fits;
  }
  for (int i = 0; i < from.inequalities(); ++i) {
    fits = add(from.Ai, i, from.equalities() + i, from.l[i], from.u[i], price[i]) && fits;
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
QpbPoint WithSlacks(const QpbProblem& p, const QpProblem<n, m>& posed,
                    const QpSolution<n, m>& solution) {
  QpbPoint at;
  at.x.assign(solution.x.data(), solution.x.data() + p.kept());
  std::vector<double> rows(p.be.size() + p.l.size(), 0.0);
  for (int i = 0; i < posed.rows; ++i) {
    rows[posed.key[i]] = solution.lambda_rows[i];
  }
  at.mu.assign(solution.lambda_box.data(), solution.lambda_box.data() + p.kept());
  at.mu.resize(static_cast<std::size_t>(p.n), 0.0);
  // A multiplier belongs to the row that the bound is of, if it is none of the file's own.
  for (int row = 0; row < p.equalities() + p.inequalities(); ++row) {
    const std::optional<BoundRow> bound = AsBound(p, row);
    if (!bound) {
      continue;
    }
    double& mu = at.mu[bound->variable];
    const bool upper =
        mu > 0 && p.ub[bound->variable] > bound->hi && bound->hi == posed.ub[bound->variable];
    const bool lower =
        mu < 0 && p.lb[bound->variable] < bound->lo && bound->lo == posed.lb[bound->variable];
    if (upper || lower) {
      rows[row] = mu / bound->a;
      mu = 0;
    }
  }
  at.nu.assign(rows.begin(), rows.begin() + p.equalities());
  at.lambda.assign(rows.begin() + p.equalities(), rows.end());
  for (int k = 0; k < p.slacks(); ++k) {
    const int i = p.soft_row[k];
    const int s = p.kept() + k;
    at.x.push_back(solution.status == QpStatus::kOptimal ? at.lambda[i] / p.H[s * p.n + s]
                                                         : MissedBy(p, i, at.x));
  }
  return at;
}

}  // namespace pipewright::hil
