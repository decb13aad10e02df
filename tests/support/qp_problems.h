// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "ctrl/qp/qp.h"
#include "platform/core/rng.h"

namespace pipewright::test {

/// How many constraints of each kind are active at the solution a problem is built from.
struct QpCase {
  const char* name;
  int at_lower = 0;
  int at_upper = 0;
  int equalities = 0;
  int at_bound = 0;
  int soft = 0;           ///< violated soft rows
  double condition = 10;  ///< of H, roughly
};

template <int n, int m>
struct KnownQp {
  QpProblem<n, m> qp;
  Vec<n> x;
  Vec<m> lambda_rows = Vec<m>::Zero();
  Vec<n> lambda_box = Vec<n>::Zero();
};

template <int n>
Vec<n> RandomVec(Rng& rng, double size = 1) {
  Vec<n> v;
  for (int i = 0; i < n; ++i) {
    v[i] = rng.Uniform(-size, size);
  }
  return v;
}

/// Symmetric positive definite, its eigenvalues spread over 1 .. 1/condition.
template <int n>
Mat<n, n> RandomHessian(Rng& rng, double condition) {
  Mat<n, n> H = Mat<n, n>::Zero();
  Vec<n> axes[n];
  for (int k = 0; k < n; ++k) {  // Gram-Schmidt, twice
    axes[k] = RandomVec<n>(rng);
    for (int i = 0; i < 2 * k; ++i) {
      axes[k] -= axes[i % k] * axes[i % k].dot(axes[k]);
    }
    axes[k].normalize();
    const double eigenvalue = n == 1 ? 1 : std::pow(condition, -static_cast<double>(k) / (n - 1));
    H += eigenvalue * axes[k] * axes[k].transpose();
  }
  return (H + H.transpose()) / 2;
}

/// A problem built backwards from a random x* and multipliers: g = -(H x* + A'lambda + lambda_box).
/// Rows beyond the active ones are satisfied with room. Active hard rows must not exceed n.
template <int n, int m>
KnownQp<n, m> MakeQp(const QpCase& c, std::uint64_t seed) {
  Rng rng(seed);
  KnownQp<n, m> known;
  QpProblem<n, m>& qp = known.qp;
  qp.H = RandomHessian<n>(rng, c.condition);
  known.x = RandomVec<n>(rng);
  const int soft_from = c.at_lower + c.at_upper + c.equalities;
  for (int i = 0; i < m; ++i) {
    const Vec<n> a = RandomVec<n>(rng).normalized();
    const double y = a.dot(known.x);
    const double lambda = rng.Uniform(0.1, 2);
    const double room = rng.Uniform(0.1, 1);
    double price = rng.Uniform() < 0.3 ? rng.Uniform(1, 1e4) : 0;
    double lo = rng.Uniform() < 0.3 ? -kInfinity : y - room;
    double hi = rng.Uniform() < 0.3 ? kInfinity : y + room;
    if (i < c.at_lower) {
      lo = y;
      known.lambda_rows[i] = -lambda;
    } else if (i < c.at_lower + c.at_upper) {
      hi = y;
      known.lambda_rows[i] = lambda;
    } else if (i < soft_from) {
      lo = hi = y;
      known.lambda_rows[i] = rng.Uniform(-2, 2);
    }
    if (i < soft_from) {
      price = 0;
    } else if (i < soft_from + c.soft) {
      price = rng.Uniform(1, 1e4);
      hi = y - lambda / (2 * price);
      lo = -kInfinity;
      known.lambda_rows[i] = lambda;
    }
    (void)qp.AddRow(a, lo, hi, price);
  }
  for (int j = 0; j < n; ++j) {
    const bool upper = rng.Uniform() < 0.5;
    const bool active = j < c.at_bound;
    qp.ub[j] = known.x[j] + (active && upper ? 0 : rng.Uniform(0.1, 1));
    qp.lb[j] = known.x[j] - (active && !upper ? 0 : rng.Uniform(0.1, 1));
    known.lambda_box[j] = active ? (upper ? 1 : -1) * rng.Uniform(0.1, 2) : 0;
  }
  qp.g = -known.lambda_box - qp.H * known.x;
  for (int i = 0; i < m; ++i) {
    qp.g -= known.lambda_rows[i] * qp.A.row(i).transpose();
  }
  return known;
}

}  // namespace pipewright::test
