// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "ctrl/qp/dual_active_set.h"
#include "ctrl/qp/row_products.h"

// How a solve begins: checked data, the unconstrained minimum, the seed of the working set.
namespace pipewright {

/// Checks the limits in one pass, factors H, finds x0. A's numbers are checked by the sweeps, see
/// MostViolated.
template <int n, int m>
typename QpSolver<n, m>::Step QpSolver<n, m>::Prepare(const Problem& qp) {
  if (!(0 <= qp.rows && qp.rows <= m)) {
    return Step::kInvalid;
  }
  bool good = true;
  bool equal = false;
  const auto check = [&](const auto& lo, const auto& hi) {
    good &= (lo <= hi && lo < kInfinity && hi > -kInfinity).all();
    equal |= (lo == hi).any();
  };
  int i = 0;
  for (; i + 8 <= qp.rows; i += 8) {
    const qp::Block lo = qp.lo.template segment<8>(i).array();
    const qp::Block hi = qp.hi.template segment<8>(i).array();
    check(lo, hi);
    good &= (qp.price.template segment<8>(i).array() >= 0).all();
    lo_.template segment<8>(i) = lo;
    hi_.template segment<8>(i) = hi;
  }
  for (; i < qp.rows; ++i) {
    check(qp.lo.template segment<1>(i).array(), qp.hi.template segment<1>(i).array());
    good &= qp.price[i] >= 0;
    lo_[i] = qp.lo[i];
    hi_[i] = qp.hi[i];
  }
  check(qp.lb.array(), qp.ub.array());
  lb_ = qp.lb;
  ub_ = qp.ub;
  equalities_ = equal;
  if (!good) {
    return Contradiction(qp);
  }
  if (!J_.Compute(qp.H)) {
    return Step::kInvalid;
  }
  V g = V::Zero();
  g.template head<n>() = qp.g;
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

template <int n, int m>
typename QpSolver<n, m>::Member QpSolver<n, m>::MakeMember(const Problem& qp, int name, int side,
                                                           bool equality) const {
  Member c;
  c.name = name;
  c.side = side;
  c.equality = equality;
  c.lambda = 0;
  c.b = side > 0 ? Upper(qp, name) : -Lower(qp, name);
  c.a.setZero();
  if (name < m) {
    c.d = qp.price[name] > 0 ? 0.5 / qp.price[name] : 0;
    c.a.template head<n>() = side * qp.A.row(name).transpose();
    c.m = J_.Apply(c.a);
  } else {
    c.d = 0;
    c.a[name - m] = side;
    c.m = side * J_.Column(name - m);
  }
  c.m2 = c.m.squaredNorm();
  return c;
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

template <int n, int m>
void QpSolver<n, m>::RestartCold(const Problem& qp) {
  for (int i = 0; i < set_.size(); ++i) {
    Mask(qp, set_[i].name, false);
  }
  set_.clear();
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
  return DropWrongSigns(qp);
}

template <int n, int m>
void QpSolver<n, m>::SeedOne(const Problem& qp, int name, int side, bool equality) {
  const bool taken = name < m ? hi_[name] == kInfinity && lo_[name] == -kInfinity
                              : ub_[name - m] == kInfinity && lb_[name - m] == -kInfinity;
  if (taken || set_.full()) {
    return;
  }
  const Member c = MakeMember(qp, name, side, equality);
  set_.ProjectToAppend(c, projection_);
  if (!projection_.dependent && (equality || projection_.pivot > kSeedPivot * c.m2)) {
    set_.Append(c, projection_);
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
