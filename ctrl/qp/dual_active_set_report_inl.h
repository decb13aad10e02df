// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "ctrl/qp/dual_active_set.h"

// How a solve ends: the answer, or the safe point in its place, and what the next solve starts
// from.
namespace pipewright {

template <int n, int m>
void QpSolver<n, m>::Report(const Problem& qp, Step end, const Vec<n>* feasible) {
  const bool iterated = end == Step::kCapped || end == Step::kFull || end == Step::kWornOut ||
                        end == Step::kIllConditioned ||
                        (end == Step::kInfeasible && set_.size() > 0);
  warm_size_ = 0;
  solution_.hard_feasible = false;
  if (end == Step::kOptimal) {
    solution_.status = QpStatus::kOptimal;
    solution_.hard_feasible = true;
    solution_.x = x_.template head<n>();
    ReportMultipliers();
    RememberActiveSet(qp);
    return;
  }
  if (iterated) {
    solution_.x = x_.template head<n>();
  } else {
    solution_.x.setZero();
  }
  if (feasible != nullptr && feasible->allFinite()) {
    solution_.x = *feasible;
    solution_.hard_feasible = end != Step::kInvalid && HardFeasible(qp, *feasible);
  }
  if (end == Step::kInvalid) {
    solution_.status = QpStatus::kInvalid;
  } else if (end == Step::kInfeasible && !solution_.hard_feasible) {
    solution_.status = QpStatus::kInfeasible;
  } else {  // capped, or called infeasible against the evidence of a feasible point
    solution_.status = QpStatus::kCapped;
    solution_.conflict.clear();
    if (solution_.hard_feasible) {
      Retreat(qp, *feasible);
    } else if (feasible == nullptr) {
      solution_.hard_feasible = HardFeasible(qp, solution_.x);
    }
    RememberActiveSet(qp);
  }
}

template <int n, int m>
void QpSolver<n, m>::ReportMultipliers() {
  for (int k = 0; k < folded_count_; ++k) {
    const qp::FoldedRow<n>& row = folded_[k];
    solution_.lambda_rows[row.name] = row.out ? 0 : row.side * std::max(row.Multiplier(x_), 0.0);
  }
  for (int i = 0; i < set_.size(); ++i) {
    const Member& c = set_[i];
    const double lambda = c.side * (c.equality ? set_.lambda(i) : std::max(set_.lambda(i), 0.0));
    if (c.d < 0) {  // a folded row that is out
      continue;
    }
    if (c.name < m) {
      solution_.lambda_rows[c.name] = lambda;
    } else {
      solution_.lambda_box[c.name - m] = lambda;
    }
  }
}

template <int n, int m>
void QpSolver<n, m>::RememberActiveSet(const Problem& qp) {
  warm_size_ = 0;
  for (int k = 0; k < folded_count_; ++k) {
    const qp::FoldedRow<n>& row = folded_[k];
    if (!row.out) {
      warm_[warm_size_++] = {row.name, qp.key[row.name], row.side};
    }
  }
  for (int i = 0; i < set_.size(); ++i) {
    const Member& c = set_[i];
    if (!c.equality && c.d >= 0) {
      warm_[warm_size_++] = {c.name, c.name < m ? qp.key[c.name] : 0, c.side};
    }
  }
}

/// x = from + t (iterate - from), t <= 1 the largest that breaks no hard row or bound.
template <int n, int m>
void QpSolver<n, m>::Retreat(const Problem& qp, const Vec<n>& from) {
  const Vec<n> step = x_.template head<n>() - from;
  double t = 1;
  const double enough = config_.feasibility_tol / 2;  // an equality that holds is no limit
  const auto limit = [&t, enough](double y, double slope, double lo, double hi) {
    if (y + slope > hi + enough) {
      t = std::min(t, (hi - y) / slope);
    } else if (y + slope < lo - enough) {
      t = std::min(t, (lo - y) / slope);
    }
  };
  for (int i = 0; i < qp.rows; ++i) {
    if (qp.price[i] == 0) {
      limit(qp.A.row(i).dot(from), qp.A.row(i).dot(step), qp.lo[i], qp.hi[i]);
    }
  }
  for (int j = 0; j < n; ++j) {
    limit(from[j], step[j], qp.lb[j], qp.ub[j]);
  }
  const Vec<n> x = from + std::max(t, 0.0) * step;
  if (HardFeasible(qp, x)) {
    solution_.x = x;
  }
}

template <int n, int m>
bool QpSolver<n, m>::HardFeasible(const Problem& qp, const Vec<n>& x) const {
  const double tolerance = config_.feasibility_tol;
  bool holds = true;
  for (int i = 0; i < qp.rows; ++i) {
    const double y = qp.A.row(i).dot(x);
    holds &= qp.price[i] > 0 || (y <= qp.hi[i] + tolerance && y >= qp.lo[i] - tolerance);
  }
  for (int j = 0; j < n; ++j) {
    holds &= x[j] <= qp.ub[j] + tolerance && x[j] >= qp.lb[j] - tolerance;
  }
  return holds;
}

}  // namespace pipewright
