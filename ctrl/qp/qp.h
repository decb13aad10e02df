// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "platform/core/fixed_vector.h"
#include "platform/core/frames.h"

namespace pipewright {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A strictly convex dense QP of at most n variables and m rows:
///
///   minimise    1/2 x'Hx + g'x + sum over soft i of price_i s_i^2
///   subject to  lo_i <= a_i'x <= hi_i          price_i = 0: hard
///               lo_i <= a_i'x - s_i <= hi_i    price_i > 0: soft; s_i is no variable, its cost
///                                              regularises the dual by 1/(2 price_i)
///               lb <= x <= ub                  hard, no row stored
///
/// lo_i = hi_i marks an equality. -inf / +inf: no such side. H (n x n) is symmetric positive
/// definite, both triangles are given. Units are the caller's; scale rows to order one, for
/// feasibility is judged by an absolute tolerance (QpConfig).
template <int n, int m>
struct QpProblem {
  static_assert(1 <= n && n <= 32 && 1 <= m && m <= 256);
  static constexpr int kVariables = n;
  static constexpr int kMaxRows = m;
  static constexpr int kStride = (m + 7) / 8 * 8;  ///< rows are tested in blocks of eight

  Mat<n, n> H = Mat<n, n>::Identity();
  Vec<n> g = Vec<n>::Zero();
  Vec<n> lb = Vec<n>::Constant(-kInfinity);
  Vec<n> ub = Vec<n>::Constant(kInfinity);

  int rows = 0;  ///< of those below
  Mat<kStride, n> A = Mat<kStride, n>::Zero();
  Vec<kStride> lo = Vec<kStride>::Zero();
  Vec<kStride> hi = Vec<kStride>::Zero();
  Vec<kStride> price = Vec<kStride>::Zero();
  /// Names of rows that outlive the problem: a warm start finds last time's active rows by them.
  /// Keys need not be unique nor sorted; a wrong one costs iterations, never the answer.
  int key[kStride] = {};

  void ClearRows() { rows = 0; }

  /// False, and nothing changed, when all m rows are taken. key < 0: the row's index.
  [[nodiscard]] bool AddRow(const Vec<n>& a, double row_lo, double row_hi, double row_price = 0,
                            int row_key = -1) {
    if (rows == m) {
      return false;
    }
    A.row(rows) = a.transpose();
    lo[rows] = row_lo;
    hi[rows] = row_hi;
    price[rows] = row_price;
    key[rows] = row_key < 0 ? rows : row_key;
    ++rows;
    return true;
  }
};

enum class QpStatus : std::uint8_t {
  kOptimal,     ///< the KKT conditions hold at x, checked
  kInfeasible,  ///< no x satisfies the rows listed in `conflict` together
  kCapped,      ///< work bound met, or arithmetic too ill conditioned to certify an optimum: x is
                ///< a hard-feasible point if hard_feasible says so, but not the optimum
  kInvalid,     ///< not a number among the inputs, H not positive definite, or a price < 0
};

/// What a solve claims. Rows are named by index; m + j names the box bound of variable j.
template <int n, int m>
struct QpSolution {
  QpStatus status = QpStatus::kInvalid;
  bool hard_feasible = false;  ///< x satisfies every hard row and the box, checked
  int iterations = 0;          ///< constraints added and dropped: the work bound counts these
  Vec<n> x = Vec<n>::Zero();
  Vec<m> lambda_rows = Vec<m>::Zero();  ///< >= 0 where a'x = hi, <= 0 where a'x = lo, else 0
  Vec<n> lambda_box = Vec<n>::Zero();   ///< likewise
  FixedVector<int, n + 1> conflict;     ///< kInfeasible: rows that exclude each other
};

/// Largest violation of the KKT conditions at a solution; 0 is exact. Test oracle and telemetry.
///
///   stationarity      Hx + g + A'lambda + lambda_box = 0
///   feasibility       lo <= a_i'x - s_i <= hi with s_i = lambda_i / (2 price_i), lb <= x <= ub
///   complementarity   lambda+ _|_ hi - (a'x - s),   lambda- _|_ (a'x - s) - lo
template <int n, int m>
double KktResidual(const QpProblem<n, m>& qp, const QpSolution<n, m>& s) {
  double worst = 0;
  const auto see = [&worst](double r) { worst = r <= worst ? worst : r; };  // NaN is worst
  const auto bounds = [&see](double y, double lo, double hi, double lambda) {
    see(y - hi);
    see(lo - y);
    if (lambda > 0) {
      see(lambda * (hi - y));
    }
    if (lambda < 0) {
      see(-lambda * (y - lo));
    }
  };
  Vec<n> stationarity = qp.g + s.lambda_box;
  stationarity += qp.H * s.x;
  for (int i = 0; i < qp.rows; ++i) {
    const double slack = qp.price[i] > 0 ? s.lambda_rows[i] / (2 * qp.price[i]) : 0;
    bounds(qp.A.row(i).dot(s.x) - slack, qp.lo[i], qp.hi[i], s.lambda_rows[i]);
    stationarity += qp.A.row(i).transpose() * s.lambda_rows[i];
  }
  for (int j = 0; j < n; ++j) {
    bounds(s.x[j], qp.lb[j], qp.ub[j], s.lambda_box[j]);
    see(stationarity[j] < 0 ? -stationarity[j] : stationarity[j]);
  }
  return worst;
}

}  // namespace pipewright
