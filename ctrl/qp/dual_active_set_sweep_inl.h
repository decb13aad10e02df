// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "ctrl/qp/dual_active_set.h"
#include "ctrl/qp/row_kernels.h"

// Which rows and bounds the iterate misses.
namespace pipewright {

/// Measures every row and bound at x. worst_: the one that x misses by most, -1 if none by more
/// than the tolerance; candidates_: those that it misses by nearly as much. A's numbers are checked
/// by the way: a row that is not finite gives a product that is not. @returns false then
template <int n, int m>
bool QpSolver<n, m>::Sweep(const Problem& qp) {
  const Vec<n> missed_box = (x_.template head<n>() - ub_).cwiseMax(lb_ - x_.template head<n>());
  const qp::RowMisses rows = qp::MeasureRows<n, Problem::kStride>(
      qp.A.data(), qp.rows, x_.data(), lo_.data(), hi_.data(), missed_.data(), most_.data());
  const double box_worst = missed_box.maxCoeff();
  const double worst = std::max(rows.worst, box_worst);
  worst_ = -1;
  candidate_count_ = 0;
  if (worst > Tolerance()) {
    worth_ = std::max(kNearlyAsMuch * worst, Tolerance());
    int found = 0;
    const auto see = [this, &found, worst](int name, double missed) {
      candidates_[found] = name;  // first written, then counted: that cannot be foretold
      found += missed > worth_ ? 1 : 0;
      worst_ = missed == worst ? name : worst_;
    };
    if (box_worst > worth_) {
      for (int j = 0; j < n; ++j) {
        see(m + j, missed_box[j]);
      }
    }
    for (int i = 0; i < qp.rows; i += qp::kRowBlock) {
      if (most_[i / qp::kRowBlock] > worth_) {
        for (int k = i; k < i + qp::kRowBlock; ++k) {
          see(k, missed_[k]);
        }
      }
    }
    candidate_count_ = std::min(found, kMaxCandidates);
  }
  return rows.finite;
}

/// By how much x misses a row or bound; negative: it holds.
template <int n, int m>
double QpSolver<n, m>::Violation(const Problem& qp, int name) const {
  if (name < m) {
    const double y = qp.A.row(name).dot(x_.template head<n>());
    return std::max(y - hi_[name], lo_[name] - y);
  }
  return std::max(x_[name - m] - ub_[name - m], lb_[name - m] - x_[name - m]);
}

/// The one that x misses by most of what the last sweep found; -1: none is worth a step before the
/// next sweep.
template <int n, int m>
int QpSolver<n, m>::MostViolated(const Problem& qp) const {
  double most = worth_;
  int which = -1;
  for (int k = 0; k < candidate_count_; ++k) {
    const double v = Violation(qp, candidates_[k]);
    if (v > most) {
      most = v;
      which = candidates_[k];
    }
  }
  return which;
}

}  // namespace pipewright
