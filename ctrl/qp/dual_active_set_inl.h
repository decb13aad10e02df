// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "ctrl/qp/dual_active_set.h"
#include "ctrl/qp/dual_active_set_polish_inl.h"
#include "ctrl/qp/dual_active_set_report_inl.h"
#include "ctrl/qp/dual_active_set_start_inl.h"
#include "ctrl/qp/dual_active_set_sweep_inl.h"

namespace pipewright {

template <int n, int m>
const QpSolution<n, m>& QpSolver<n, m>::Solve(const Problem& qp, const Vec<n>* feasible) {
  solution_.iterations = 0;
  solution_.lambda_rows.setZero();
  solution_.lambda_box.setZero();
  solution_.conflict.clear();
  fold_ = true;
  Step step = Start(qp);
  for (int i = 0; i < kMaxRestarts; ++i) {
    if (step == Step::kFull || (step == Step::kWornOut && fold_)) {
      RememberActiveSet(qp);
      fold_ = step == Step::kFull;
    } else if ((step == Step::kIllConditioned || step == Step::kWornOut) && warm_size_ > 0) {
      ForgetActiveSet();  // perhaps it is the seed that was
      fold_ = true;
    } else {
      break;
    }
    step = Start(qp);
  }
  Report(qp, step, feasible);
  return solution_;
}

template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Start(const Problem& qp) {
  set_.clear();
  folded_count_ = 0;
  begun_ = solution_.iterations;
  lost_ = 1;
  widened_ = 1;
  const Step step = Prepare(qp);
  return step == Step::kGoOn ? SolveFromSeed(qp) : step;
}

/// Counts an iteration. A start with folded rows is given a quarter of them: it is quick or wrong.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Count() {
  ++solution_.iterations;
  if (fold_ && folded_count_ > 0 && set_.size() < kMaxActive / 2 &&
      4 * (solution_.iterations - begun_) > config_.max_iterations) {
    return Step::kWornOut;
  }
  return solution_.iterations > config_.max_iterations ? Step::kCapped : Step::kGoOn;
}

template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::SolveFromSeed(const Problem& qp) {
  Step step = Seed(qp);
  int rescues = 0;
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
    // A dependent row that is missed, and no proof: perhaps it was the rounding of x, or else that
    // of the data, where many rows meet in a point that they do not determine well.
    if (step == Step::kIllConditioned && rescues < kMaxRescues) {
      widened_ = ++rescues < kMaxRescues ? 1 : kWider;
      step = Refine(qp);
    }
  }
  return step;
}

/// Steps 1 and 2 of Goldfarb and Idnani: raises the multiplier of the violated constraint p until
/// it holds, dropping each constraint whose multiplier reaches zero on the way.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Add(const Problem& qp, int name) {
  Member p;
  double lambda = 0;
  const V a = Row(qp, name);
  MakeMember(qp, name, a.dot(x_) > Upper(qp, name) ? 1 : -1, a, p);
  while (true) {
    const Step counted = Count();
    if (counted != Step::kGoOn || set_.full()) {
      return counted != Step::kGoOn ? counted : Step::kFull;
    }
    set_.Project(p, projection_);
    double t = kInfinity;
    const int blocking = set_.FirstToReachZero(projection_, t);
    int leaving = -1;
    bool full_step = false;
    if (!projection_.dependent) {
      const V dx = J_.ApplyTransposed(projection_.z);
      leaving = FirstFoldedToReachZero(dx, t);
      const double t_full = (p.a.dot(x_) - p.b - p.d * lambda) / projection_.pivot;
      if (t_full <= t) {
        t = std::max(t_full, 0.0);
        full_step = true;
      }
      x_ -= t * dx;
    } else if (blocking < 0) {
      if (!ProvesInfeasible(p)) {
        return Step::kIllConditioned;
      }
      NameConflict(p);
      return Step::kInfeasible;
    }
    set_.Fall(t, projection_);
    lambda += t;
    if (full_step) {
      set_.Append(p, lambda, projection_);
      Mask(qp, name, true);
      return Step::kGoOn;
    }
    if (leaving < 0 && blocking < 0) {  // a step that is no number
      return Step::kIllConditioned;
    }
    const Step gone = leaving >= 0 ? TakeOut(qp, leaving) : Drop(qp, blocking);
    if (gone != Step::kGoOn) {
      return gone;
    }
  }
}

/// A member leaves: its row may be violated again. One that took a folded row out: the row is back.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Drop(const Problem& qp, int member) {
  const int name = set_[member].name;
  const bool back = set_[member].d < 0;
  Mask(qp, name, back);
  const bool exact = set_.Remove(member);
  for (int k = 0; back && k < folded_count_; ++k) {
    folded_[k].out &= folded_[k].name != name;
  }
  return exact || set_.Refactor(projection_) ? Step::kGoOn : Step::kIllConditioned;
}

/// A folded row whose multiplier is no longer positive leaves. Each costs digits of S; before they
/// are too many, the rest go on as members.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::TakeOut(const Problem& qp, int folded) {
  if (set_.full()) {
    return Step::kFull;
  }
  qp::FoldedRow<n>& row = folded_[folded];
  Member& c = set_.Next();
  c.name = row.name;
  c.side = row.side;
  c.equality = false;
  c.d = -1 / row.w;
  c.b = row.b;
  c.a = row.a;
  c.m = J_.Apply(c.a);
  c.m2 = c.m.squaredNorm();
  set_.Project(c, projection_);
  lost_ /= row.w * std::fabs(projection_.pivot);  // of 1 / w that much is left
  if (projection_.dependent || !(lost_ < kLost)) {
    return Step::kWornOut;
  }
  set_.Append(c, 0, projection_);
  row.out = true;
  Mask(qp, row.name, false);
  return Step::kGoOn;
}

/// While some inequality pulls, lets the one that pulls most go and solves on what is left: in the
/// end the minimum over the set with multipliers >= 0, a lawful start of the dual method. x and the
/// multipliers are those of the set.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::DropWrongSigns(const Problem& qp) {
  while (true) {
    int worst = -1;
    double most = 0;
    double largest = 0;
    for (int i = 0; i < set_.size(); ++i) {
      largest = std::max(largest, set_.lambda(i));
      if (!set_[i].equality && set_.lambda(i) < most) {
        most = set_.lambda(i);
        worst = i;
      }
    }
    int folded = -1;
    for (int k = 0; k < folded_count_; ++k) {
      const double lambda = folded_[k].out ? 0 : folded_[k].Multiplier(x_);
      largest = std::max(largest, lambda);
      if (lambda < most && lambda < -kWrongSign * largest) {  // w rounding (a'x) is no wrong sign
        most = lambda;
        folded = k;
      }
    }
    if (worst < 0 && folded < 0) {
      return Step::kGoOn;
    }
    const Step counted = Count();
    if (counted != Step::kGoOn) {
      return counted;
    }
    const Step gone = folded >= 0 ? TakeOut(qp, folded) : Drop(qp, worst);
    if (gone != Step::kGoOn) {
      return gone;
    }
    SolveOnWorkingSet();
  }
}

/// x = x0 - J'M'lambda.
template <int n, int m>
void QpSolver<n, m>::SolveOnWorkingSet() {
  x_ = x0_ + J_.ApplyTransposed(set_.Settle(x0_));
}

/// The same among the folded rows, whose multipliers change by w a'dx; t is the step so far
/// allowed. An error e of z is one of (J a)'e in a'dx, and |J a|^2 <= 1 / w, for w a a' is in H.
template <int n, int m>
int QpSolver<n, m>::FirstFoldedToReachZero(const V& dx, double& t) const {
  int first = -1;
  for (int k = 0; k < folded_count_; ++k) {
    const qp::FoldedRow<n>& row = folded_[k];
    const double slope = row.a.dot(dx);
    if (!row.out && slope > 0 && row.w * slope * slope > projection_.noise2) {
      const double reach = std::max(row.a.dot(x_) - row.b, 0.0);
      if (reach < t * slope) {
        t = reach / slope;
        first = k;
      }
    }
  }
  return first;
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
