// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "ctrl/qp/dual_active_set.h"
#include "ctrl/qp/dual_active_set_report_inl.h"
#include "ctrl/qp/dual_active_set_start_inl.h"
#include "ctrl/qp/row_products.h"

namespace pipewright {

template <int n, int m>
const QpSolution<n, m>& QpSolver<n, m>::Solve(const Problem& qp, const Vec<n>* feasible) {
  solution_.iterations = 0;
  solution_.lambda_rows.setZero();
  solution_.lambda_box.setZero();
  solution_.conflict.clear();
  set_.clear();
  Step step = Prepare(qp);
  if (step == Step::kGoOn) {
    step = SolveFromSeed(qp);
  }
  if (step == Step::kIllConditioned && warm_size_ > 0) {  // perhaps it is the seed that was
    ForgetActiveSet();
    RestartCold(qp);
    step = SolveFromSeed(qp);
  }
  Report(qp, step, feasible);
  return solution_;
}

template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::SolveFromSeed(const Problem& qp) {
  Step step = Seed(qp);
  while (step == Step::kGoOn) {
    if (!Sweep(qp)) {
      return Step::kInvalid;
    }
    if (worst_ < 0) {
      step = Polish(qp);
    }
    for (int name = worst_; name >= 0 && step == Step::kGoOn; name = MostViolated(qp)) {
      step = Add(qp, name);
    }
  }
  return step;
}

/// Measures every row and bound at x. worst_: the one that x misses by most, -1 if none by more
/// than the tolerance; candidates_: those that it misses by nearly as much. A's numbers are checked
/// by the way: a row that is not finite gives a product that is not. @returns false then
template <int n, int m>
bool QpSolver<n, m>::Sweep(const Problem& qp) {
  using qp::Block;
  Block most = Block::Constant(-kInfinity);
  Block probe = Block::Zero();
  for (int i = 0; i < qp.rows; i += 8) {
    const Block y = qp::ProductBlock(qp, x_, i);
    Block v = (y - hi_.template segment<8>(i).array()).max(lo_.template segment<8>(i).array() - y);
    if (i + 8 <= qp.rows) {
      probe += 0 * y;
    } else {  // past the last row lies what an earlier problem left
      probe[0] += 0 * y.head(qp.rows - i).sum();
      v.tail(i + 8 - qp.rows).setConstant(-kInfinity);
    }
    missed_.template segment<8>(i) = v;
    most = most.max(v);
  }
  const auto x = x_.template head<n>();
  const Vec<n> missed_box = (x - ub_).cwiseMax(lb_ - x);
  const double worst = std::max(most.maxCoeff(), missed_box.maxCoeff());
  worst_ = -1;
  candidate_count_ = 0;
  if (worst > Tolerance()) {
    worth_ = std::max(kNearlyAsMuch * worst, Tolerance());
    const auto see = [this, worst](int name, double missed) {
      if (missed > worth_ && candidate_count_ < kMaxCandidates) {
        candidates_[candidate_count_++] = name;
      }
      if (missed == worst) {
        worst_ = name;
      }
    };
    for (int j = 0; j < n; ++j) {
      see(m + j, missed_box[j]);
    }
    for (int i = 0; i < qp.rows; ++i) {
      see(i, missed_[i]);
    }
  }
  return probe.sum() == 0;
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

/// Steps 1 and 2 of Goldfarb and Idnani: raises the multiplier of the violated constraint p until
/// it holds, dropping each constraint whose multiplier reaches zero on the way.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Add(const Problem& qp, int name) {
  const double value = name < m ? qp.A.row(name).dot(x_.template head<n>()) : x_[name - m];
  const bool high = value > Upper(qp, name);
  Member p = MakeMember(qp, name, high ? 1 : -1, Lower(qp, name) == Upper(qp, name));
  while (true) {
    if (++solution_.iterations > config_.max_iterations || set_.full()) {
      return Step::kCapped;
    }
    set_.Project(p, projection_);
    double t = kInfinity;
    const int blocking = FirstToReachZero(t);
    bool full_step = false;
    if (!projection_.dependent) {
      const double t_full = (p.a.dot(x_) - p.b - p.d * p.lambda) / projection_.pivot;
      if (t_full <= t) {
        t = std::max(t_full, 0.0);
        full_step = true;
      }
      x_ -= t * J_.ApplyTransposed(projection_.z);
    } else if (blocking < 0) {
      if (!ProvesInfeasible(p)) {
        return Step::kIllConditioned;
      }
      NameConflict(p);
      return Step::kInfeasible;
    }
    for (int i = 0; i < set_.size(); ++i) {
      set_[i].lambda -= t * projection_.r[i];
    }
    p.lambda += t;
    if (full_step) {
      set_.Append(p, projection_);
      Mask(qp, name, true);
      return Step::kGoOn;
    }
    if (blocking < 0) {  // a step that is no number
      return Step::kIllConditioned;
    }
    Mask(qp, set_[blocking].name, false);
    set_.Remove(blocking);
  }
}

/// Solves on the seed; while some inequality pulls, drops the one that pulls most. What remains is
/// the minimum over its rows with multipliers >= 0: a lawful start of the dual method.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::DropWrongSigns(const Problem& qp) {
  while (true) {
    SolveOnWorkingSet();
    int worst = -1;
    double most = 0;
    for (int i = 0; i < set_.size(); ++i) {
      if (!set_[i].equality && set_[i].lambda < most) {
        most = set_[i].lambda;
        worst = i;
      }
    }
    if (worst < 0) {
      return Step::kGoOn;
    }
    if (++solution_.iterations > config_.max_iterations) {
      return Step::kCapped;
    }
    Mask(qp, set_[worst].name, false);
    set_.Remove(worst);
  }
}

/// lambda = S^-1 (a_i'x0 - b_i),  x = x0 - J'M'lambda.
template <int n, int m>
void QpSolver<n, m>::SolveOnWorkingSet() {
  double* const w = work_;
  V z = V::Zero();
  for (int i = 0; i < set_.size(); ++i) {
    w[i] = set_[i].a.dot(x0_) - set_[i].b;
  }
  set_.Solve(w, w);
  for (int i = 0; i < set_.size(); ++i) {
    set_[i].lambda = w[i];
    z += w[i] * set_[i].m;
  }
  x_ = x0_ - J_.ApplyTransposed(z);
}

/// Which multiplier the step along projection_ brings to zero first, and at what length; -1: none.
template <int n, int m>
int QpSolver<n, m>::FirstToReachZero(double& t) const {
  int first = -1;
  for (int i = 0; i < set_.size(); ++i) {
    const Member& c = set_[i];
    const double r = projection_.r[i];
    if (!c.equality && r > 0 && r * r * c.m2 > projection_.noise2 && c.lambda < t * r) {
      t = c.lambda / r;
      first = i;
    }
  }
  return first;
}

/// At a point that satisfies every row: makes the KKT residual in the original data small, or says
/// that it cannot be. Refining moves x; if that breaks a row or a sign, the method goes on.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Polish(const Problem& qp) {
  double* const w = work_;
  V s;
  double residual = Residual(qp, s, w);
  if (residual <= kSmallResidual) {
    return Step::kOptimal;
  }
  if (++solution_.iterations > config_.max_iterations) {
    return Step::kCapped;
  }
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
    largest = std::max(largest, std::fabs(set_[i].lambda));
    least = set_[i].equality ? least : std::min(least, set_[i].lambda);
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
template <int n, int m>
double QpSolver<n, m>::Residual(const Problem& qp, V& s, double* w) const {
  s.setZero();
  for (int j = 0; j < n; ++j) {
    s.template head<n>() += qp.H.col(j) * x_[j];
  }
  double scale =
      std::max(s.template lpNorm<Eigen::Infinity>(), qp.g.template lpNorm<Eigen::Infinity>());
  s.template head<n>() += qp.g;
  double worst = 0;
  for (int i = 0; i < set_.size(); ++i) {
    const Member& c = set_[i];
    s += c.lambda * c.a;
    scale = std::max(scale, std::fabs(c.lambda));
    w[i] = c.a.dot(x_) - c.d * c.lambda - c.b;
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
    set_[i].lambda += w[i];
    z += w[i] * set_[i].m;
  }
  x_ -= J_.ApplyTransposed(z);
}

/// Whether projection_ is a proof in the problem's own data: with v = a_p - sum r_i a_i and r_i <=
/// 0 for inequalities, every x that keeps the set has a_p'x >= sum r_i b_i - |v|_1 |x|_max, so none
/// with |x|_max up to a thousand times the present one keeps p.
template <int n, int m>
bool QpSolver<n, m>::ProvesInfeasible(const Member& p) const {
  constexpr double kFar = 1e3;
  V v = p.a;
  double gap = -p.b;
  for (int i = 0; i < set_.size(); ++i) {
    v -= projection_.r[i] * set_[i].a;
    gap += projection_.r[i] * set_[i].b;
  }
  const double far = kFar * std::max(1.0, x_.template lpNorm<Eigen::Infinity>());
  return gap > far * v.template lpNorm<1>();
}

/// The rows of a proof of infeasibility: a_p = sum r_i a_i with r_i <= 0 for inequalities, while
/// b_p < sum r_i b_i.
template <int n, int m>
void QpSolver<n, m>::NameConflict(const Member& p) {
  (void)solution_.conflict.push_back(p.name);
  for (int i = 0; i < set_.size(); ++i) {
    const double r = projection_.r[i];
    if (r * r * set_[i].m2 > projection_.noise2) {
      (void)solution_.conflict.push_back(set_[i].name);
    }
  }
}

}  // namespace pipewright
