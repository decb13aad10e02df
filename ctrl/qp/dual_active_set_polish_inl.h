// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "ctrl/qp/dual_active_set.h"

// The residual that an optimum is claimed by, and its refinement.
namespace pipewright {

/// At a point that satisfies every row: makes the KKT residual in the original data small, or says
/// that it cannot be. Refining moves x; if that breaks a row or a sign, the method goes on.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Polish(const Problem& qp) {
  V s;
  const double residual = Residual(qp, s, work_);
  if (residual <= kSmallResidual) {
    return Step::kOptimal;
  }
  return residual > kLargeResidual && folded_count_ > 0 ? Step::kWornOut : Refine(qp, residual, s);
}

template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Refine(const Problem& qp) {
  V s;
  return Refine(qp, Residual(qp, s, work_), s);
}

/// Makes x and the multipliers those of the working set to the last digits, then looks again. s and
/// work_ are those that the residual comes from.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Refine(const Problem& qp, double residual, V& s) {
  const Step counted = Count();
  if (counted != Step::kGoOn) {
    return counted;
  }
  double* const w = work_;
  for (int pass = 0; pass < kMaxRefinements && residual > kSmallResidual; ++pass) {
    Correct(s, w);
    const double before = residual;
    residual = Residual(qp, s, w);
    if (!(residual < 0.5 * before)) {
      break;
    }
  }
  if (!(residual <= 1)) {
    return Step::kIllConditioned;
  }
  double largest = 0;
  double least = 0;
  for (int i = 0; i < set_.size(); ++i) {
    largest = std::max(largest, std::fabs(set_.lambda(i)));
    least = set_[i].equality ? least : std::min(least, set_.lambda(i));
  }
  for (int k = 0; k < folded_count_; ++k) {
    const double lambda = folded_[k].out ? 0 : folded_[k].Multiplier(x_);
    largest = std::max(largest, lambda);
    least = std::min(least, lambda);
  }
  if (least < -kWrongSign * largest) {
    return DropWrongSigns(qp);
  }
  if (!Sweep(qp)) {
    return Step::kInvalid;
  }
  return worst_ < 0 ? Step::kOptimal : Step::kGoOn;
}

/// The KKT residual on the working set, in the problem's own data: s = Hx + g + sum lambda a,
/// w_i = a_i'x - d_i lambda_i - b_i. Returned in units of the tolerances: up to 1 is an optimum.
/// A folded row's multiplier is read off x, in it or out of it.
template <int n, int m>
double QpSolver<n, m>::Residual(const Problem& qp, V& s, double* w) {
  s.setZero();
  for (int j = 0; j < n; ++j) {
    s.template head<n>() += qp.H.col(j) * x_[j];
  }
  double scale =
      std::max(s.template lpNorm<Eigen::Infinity>(), qp.g.template lpNorm<Eigen::Infinity>());
  s.template head<n>() += qp.g;
  double worst = 0;
  for (int k = 0; k < folded_count_; ++k) {
    const double lambda = folded_[k].out ? 0 : folded_[k].Multiplier(x_);
    s += lambda * folded_[k].a;
    scale = std::max(scale, std::fabs(lambda));
  }
  for (int i = 0; i < set_.size(); ++i) {
    const Member& c = set_[i];
    if (c.d < 0) {
      set_.lambda(i) = (c.a.dot(x_) - c.b) / c.d;
      w[i] = 0;
      continue;
    }
    s += set_.lambda(i) * c.a;
    scale = std::max(scale, std::fabs(set_.lambda(i)));
    w[i] = c.a.dot(x_) - c.d * set_.lambda(i) - c.b;
    worst = std::max(worst, std::fabs(w[i]));
  }
  const double feasibility = worst / Tolerance();
  const double stationarity = s.template lpNorm<Eigen::Infinity>();
  return std::isfinite(s.sum())
             ? std::max(feasibility, stationarity / (config_.stationarity_tol * scale + kTiny))
             : kInfinity;
}

/// One step of iterative refinement, [H A'; A -d] [dx; dlambda] = -[s; w]:
/// dlambda = S^-1 (w - A H^-1 s),  dx = -H^-1 s - J'M'dlambda.
template <int n, int m>
void QpSolver<n, m>::Correct(const V& s, double* w) {
  V z = J_.Apply(s);
  for (int i = 0; i < set_.size(); ++i) {
    w[i] -= set_[i].m.dot(z);
  }
  set_.Solve(w, w);
  for (int i = 0; i < set_.size(); ++i) {
    set_.lambda(i) += w[i];
    z += w[i] * set_[i].m;
  }
  x_ -= J_.ApplyTransposed(z);
}

}  // namespace pipewright
