// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "ctrl/qp/dual_active_set.h"
#include "ctrl/qp/row_kernels.h"

// How a solve begins: checked data, the unconstrained minimum, the seed of the working set.
namespace pipewright {

/// Checks the limits in one pass, folds what can be, factors H, finds x0. A's numbers are checked
/// by the sweeps.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Prepare(const Problem& qp) {
  if (!(0 <= qp.rows && qp.rows <= m)) {
    return Step::kInvalid;
  }
  const qp::LimitFlaws rows =
      qp::CopyLimits(qp.lo.data(), qp.hi.data(), qp.price.data(), qp.rows, lo_.data(), hi_.data());
  const Vec<n> zero = Vec<n>::Zero();
  const qp::LimitFlaws box =
      qp::CopyLimits(qp.lb.data(), qp.ub.data(), zero.data(), n, lb_.data(), ub_.data());
  equalities_ = rows.equal || box.equal;
  if (rows.bad || box.bad) {
    return Contradiction(qp);
  }
  Fold(qp);
  if (!J_.Compute(qp.H, folded_, folded_count_)) {
    return Step::kInvalid;
  }
  V g = V::Zero();
  g.template head<n>() = qp.g;
  for (int k = 0; k < folded_count_; ++k) {
    g -= folded_[k].w * folded_[k].b * folded_[k].a;
  }
  x0_ = -J_.ApplyTransposed(J_.Apply(g));
  return x0_.sum() * 0 == 0 ? Step::kGoOn : Step::kInvalid;
}

/// Some lo > hi is infeasible by itself when all numbers are numbers and the row is hard.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Contradiction(const Problem& qp) {
  int crossed = -1;
  for (int i = 0; i < qp.rows + n; ++i) {
    const int name = i < qp.rows ? i : m + i - qp.rows;
    const double lo = Lower(qp, name);
    const double hi = Upper(qp, name);
    const double price = name < m ? qp.price[name] : 0;
    if (std::isnan(lo) || std::isnan(hi) || lo == kInfinity || hi == -kInfinity || !(price >= 0) ||
        (lo > hi && price > 0)) {
      return Step::kInvalid;
    }
    if (lo > hi) {
      crossed = name;
    }
  }
  (void)solution_.conflict.push_back(crossed);
  return Step::kInfeasible;
}

/// a_i, two numbers at a time: what is stored one by one cannot be loaded by pairs at once.
template <int n, int m>
typename QpSolver<n, m>::V QpSolver<n, m>::Row(const Problem& qp, int name) const {
  V a;
  if (name < m) {
    for (int j = 0; j < qp::Padded(n); j += 2) {
      qp::Store(qp::Two{qp.A(name, j), j + 1 < n ? qp.A(name, j + 1) : 0}, a.data() + j);
    }
  } else {
    a.setZero();
    a[name - m] = 1;
  }
  return a;
}

template <int n, int m>
void QpSolver<n, m>::MakeMember(const Problem& qp, int name, int side, const V& a,
                                Member& c) const {
  c.name = name;
  c.side = side;
  c.equality = Lower(qp, name) == Upper(qp, name);
  c.b = side > 0 ? Upper(qp, name) : -Lower(qp, name);
  c.d = name < m && qp.price[name] > 0 ? 0.5 / qp.price[name] : 0;
  c.a = side * a;
  c.m = name < m ? J_.Apply(c.a) : V(side * J_.Column(name - m));
  c.m2 = c.m.squaredNorm();
}

/// Whether the row or bound is active or folded, or never was one.
template <int n, int m>
bool QpSolver<n, m>::Taken(int name) const {
  return name < m ? hi_[name] == kInfinity && lo_[name] == -kInfinity
                  : ub_[name - m] == kInfinity && lb_[name - m] == -kInfinity;
}

template <int n, int m>
void QpSolver<n, m>::Mask(const Problem& qp, int name, bool active) {
  if (name < m) {
    lo_[name] = active ? -kInfinity : qp.lo[name];
    hi_[name] = active ? kInfinity : qp.hi[name];
  } else {
    lb_[name - m] = active ? -kInfinity : qp.lb[name - m];
    ub_[name - m] = active ? kInfinity : qp.ub[name - m];
  }
}

/// Last time's active soft rows that still exist, unless they would make H ill conditioned.
template <int n, int m>
void QpSolver<n, m>::Fold(const Problem& qp) {
  folded_count_ = 0;
  double stiffest = kInfinity;
  for (int j = 0; j < n && warm_size_ > 0; ++j) {
    stiffest = std::min(stiffest, kStiffest * qp.H(j, j));
  }
  for (int k = 0; fold_ && k < warm_size_; ++k) {
    const Warm& warm = warm_[k];
    const int name = warm.name < m ? FindRow(qp, warm) : -1;
    if (name < 0 || !(qp.price[name] > 0) || qp.lo[name] == qp.hi[name] || Taken(name)) {
      continue;
    }
    qp::FoldedRow<n>& row = folded_[folded_count_];
    row.name = name;
    row.side = warm.side;
    row.out = false;
    row.w = 2 * qp.price[name];
    row.b = warm.side > 0 ? qp.hi[name] : -qp.lo[name];
    row.a = warm.side * Row(qp, name);
    const double a2 = row.a.squaredNorm();
    if (std::isfinite(row.b) && row.w * a2 < stiffest) {
      Mask(qp, name, true);
      ++folded_count_;
    }
  }
}

/// The working set to begin with: all equalities (dependent ones are left out: the sweep tells
/// whether they are consistent), then last time's active rows that still exist.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Seed(const Problem& qp) {
  if (equalities_) {
    for (int i = 0; i < qp.rows; ++i) {
      if (qp.lo[i] == qp.hi[i]) {
        SeedOne(qp, i, 1, true);
      }
    }
    for (int j = 0; j < n; ++j) {
      if (qp.lb[j] == qp.ub[j]) {
        SeedOne(qp, m + j, 1, true);
      }
    }
  }
  for (int k = 0; k < warm_size_; ++k) {
    const int name = warm_[k].name >= m ? warm_[k].name : FindRow(qp, warm_[k]);
    if (name < 0) {
      continue;
    }
    const double lo = Lower(qp, name);
    const double hi = Upper(qp, name);
    if (lo != hi && std::isfinite(warm_[k].side > 0 ? hi : lo)) {
      SeedOne(qp, name, warm_[k].side, false);
    }
  }
  SolveOnWorkingSet();
  return DropWrongSigns(qp);
}

template <int n, int m>
void QpSolver<n, m>::SeedOne(const Problem& qp, int name, int side, bool equality) {
  if (Taken(name) || set_.full()) {
    return;
  }
  Member& c = set_.Next();
  MakeMember(qp, name, side, Row(qp, name), c);
  set_.ProjectToAppend(c, projection_);
  if (!projection_.dependent && (equality || projection_.pivot > kSeedPivot * c.m2)) {
    set_.Append(c, 0, projection_);
    Mask(qp, name, true);
  }
}

/// The row that carries a remembered key: where it was, or else the first that has it.
template <int n, int m>
int QpSolver<n, m>::FindRow(const Problem& qp, const Warm& warm) const {
  if (warm.name < qp.rows && qp.key[warm.name] == warm.key) {
    return warm.name;
  }
  for (int i = 0; i < qp.rows; ++i) {
    if (qp.key[i] == warm.key) {
      return i;
    }
  }
  return -1;
}

}  // namespace pipewright
