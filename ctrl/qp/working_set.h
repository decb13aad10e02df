// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cmath>

#include "ctrl/qp/gram_factor.h"
#include "ctrl/qp/inverse_factor.h"

namespace pipewright::qp {

/// The constraints held active, and a factor of their Gram matrix
///
///   S = M M' + diag(d)      row i of M: m_i = J a_i,  d_i = 1/(2 price_i) or 0
///
/// a_i carries the sign that makes the constraint a_i'x - d_i lambda_i <= b_i. A member with d_i <
/// 0 takes a folded row's term back out of the cost (FoldedRow): S is then indefinite, but every
/// set of members poses a problem with one answer, so no leading minor of S is zero. S is only a
/// tool: pivots that lose digits come from an explicit residual (Project), refined once, so the
/// factor is as good as one by orthogonal transformations (corrected semi-normal equations,
/// [Bjoerck 1987]) although it costs half and holds soft rows without growing m_i.
template <int n, int kMax>
class WorkingSet {
 public:
  using V = PaddedVec<n>;
  using Factor = GramFactor<kMax>;
  static constexpr int kStride = Factor::kStride;

  struct Member {
    int name;  ///< row index, or m + j for the bound of variable j
    int side;  ///< +1: at the upper limit, -1: at the lower one
    bool equality;
    double d;
    double b;
    double m2;  ///< |m|^2
    V a;
    V m;
  };

  /// A candidate constraint against the set.
  struct Projection {
    double r[kStride];  ///< S^-1 M m_p: how the set's multipliers fall as the candidate's grows.
                        ///< Padded with zeros to whole blocks
    V z;                ///< m_p - M'r: what is new in m_p
    double pivot = 0;   ///< m_p'm_p + d_p - (M m_p)'r = |z|^2 + sum d_i r_i^2 + d_p
    double noise2 = 0;  ///< r_i^2 |m_i|^2 below this is rounding
    bool dependent = false;  ///< a_p is a combination of the set, to rounding
  };

  int size() const { return factor_.size(); }
  bool full() const { return size() == kMax; }
  void clear() { factor_.clear(); }
  const Member& operator[](int i) const { return members_[i]; }
  double lambda(int i) const { return lambda_[i]; }
  double& lambda(int i) { return lambda_[i]; }
  /// Room for a candidate, lost with the next change of the set; appended from here it is not
  /// copied.
  Member& Next() { return members_[size()]; }

  /// r, z and pivot. n k + k^2 multiply-adds for r, n k for z.
  void Project(const Member& candidate, Projection& p) {
    Multipliers(candidate, p);
    Complete(candidate, p);
  }

  /// As Project, but z is formed only when the pivot has lost digits: enough for Append.
  void ProjectToAppend(const Member& candidate, Projection& p) {
    Multipliers(candidate, p);
    p.noise2 = kRounding * kRounding * candidate.m2;
    p.dependent = false;
    if (!(p.pivot > kApart * (candidate.m2 + candidate.d))) {
      Complete(candidate, p);
    }
  }

  /// Which inequality's multiplier the step along p brings to zero first, and at what length; -1:
  /// none within t.
  int FirstToReachZero(const Projection& p, double& t) {
    double* const reach = w_;
    for (int i = 0; i < size(); i += 2) {
      Two r;
      Two m2;
      Two lambda;
      Load(p.r + i, r);
      Load(falling_m2_ + i, m2);
      Load(lambda_ + i, lambda);
      const auto falls = (r > 0) & (r * r * m2 > p.noise2);
      const Two never = Two{} + kInfinity;
      Store(falls ? lambda / r : never, reach + i);
    }
    int first = -1;
    for (int i = 0; i < size(); ++i) {
      const bool sooner = reach[i] < t;
      t = sooner ? reach[i] : t;
      first = sooner ? i : first;
    }
    return first;
  }

  /// lambda -= t r.
  void Fall(double t, const Projection& p) {
    for (int i = 0; i < size(); i += 4) {
      Block::Map(lambda_ + i) -= t * Block::Map(p.r + i);
    }
  }

  /// Adds a constraint, of multiplier lambda, with the projection computed for it against the
  /// present set.
  void Append(const Member& member, double lambda, const Projection& p) {
    const int at = size();
    assert(at < kMax && !p.dependent);
    if (&member != &members_[at]) {
      members_[at] = member;
    }
    if (at % 4 == 0) {  // a new block: what an earlier solve left there may be no number
      for (int i = at + 1; i < at + 4; ++i) {
        members_[i].m.setZero();
      }
      for (int i = at; i < at + 5; ++i) {
        d_[i] = 0;
        falling_m2_[i] = 0;
      }
    }
    lambda_[at] = lambda;
    d_[at] = member.d;
    falling_m2_[at] = member.equality ? 0 : member.m2;
    factor_.Append(p.r, p.pivot);
  }

  /// Removes constraint `gone`. @returns false when S has lost digits by it: Refactor
  bool Remove(int gone) {
    Factor::TakeOut(gone, size(), d_);
    Factor::TakeOut(gone, size(), falling_m2_);
    for (int i = gone + 1; i < size(); ++i) {
      members_[i - 1] = members_[i];
      lambda_[i - 1] = lambda_[i];
    }
    return factor_.Remove(gone);
  }

  /// Factors S anew. @returns false when a member has become dependent on those before it
  bool Refactor(Projection& p) {
    const int size = factor_.size();
    factor_.clear();
    for (int i = 0; i < size; ++i) {
      Project(members_[i], p);
      if (p.dependent) {
        return false;
      }
      factor_.Append(p.r, p.pivot);
    }
    return true;
  }

  /// lambda = S^-1 (a_i'x0 - b_i). @returns -M'lambda
  V Settle(const V& x0) {
    for (int i = 0; i < size(); i += 2) {
      const Member& even = members_[i];
      const Member& odd = members_[i + 1];
      const Two y =
          SumPairs(Dot<kPadded>(even.a.data(), x0.data()), Dot<kPadded>(odd.a.data(), x0.data()));
      Store(y - Two{even.b, odd.b}, w_ + i);
    }
    factor_.Solve(w_, lambda_);
    V z = V::Zero();
    Subtract(lambda_, z);
    return z;
  }

  /// x = S^-1 w; x may be w. Both have room for kStride.
  void Solve(double* w, double* x) const { factor_.Solve(w, x); }

 private:
  using Block = Eigen::Array<double, 4, 1>;
  static constexpr int kPadded = Padded(n);
  static constexpr double kApart = 1e-5;  ///< of its diagonal: less, and the pivot is formed anew
  static constexpr double kCancelled = 1e-5;  ///< of |m_p|^2: below, z has lost digits
  static constexpr double kRounding = 1e-12;

  void Multipliers(const Member& candidate, Projection& p) {
    Apply(candidate.m, w_);
    factor_.SolveFinite(w_, p.r);
    Block known = Block::Zero();
    for (int i = 0; i < size(); i += 4) {
      known += Block::Map(w_ + i) * Block::Map(p.r + i);
    }
    p.pivot = candidate.m2 + candidate.d - known.sum();
  }

  void Complete(const Member& candidate, Projection& p) {
    p.z = candidate.m;
    Subtract(p.r, p.z);
    double z2 = p.z.squaredNorm();
    double scale2 = candidate.m2;
    if (z2 + candidate.d < kCancelled * candidate.m2) {
      Refine(p);
      z2 = p.z.squaredNorm();
      for (int i = 0; i < size(); ++i) {
        scale2 += p.r[i] * p.r[i] * members_[i].m2;
      }
    }
    p.noise2 = kRounding * kRounding * scale2;
    Block softened = Block::Zero();
    for (int i = 0; i < size(); i += 4) {
      softened += Block::Map(d_ + i) * Block::Map(p.r + i).square();
    }
    p.pivot = z2 + candidate.d + softened.sum();
    p.dependent = candidate.d < 0 ? !(p.pivot < 0) : p.pivot <= p.noise2;
  }

  /// One step of refinement of S r = M m_p: its residual is M z - d r.
  void Refine(Projection& p) {
    Apply(p.z, w_);
    for (int i = 0; i < size(); i += 4) {
      Block::Map(w_ + i) -= Block::Map(d_ + i) * Block::Map(p.r + i);
    }
    factor_.SolveFinite(w_, w_);
    for (int i = 0; i < size(); i += 4) {
      Block::Map(p.r + i) += Block::Map(w_ + i);
    }
    Subtract(w_, p.z);
  }

  /// w = M v, padded with numbers.
  void Apply(const V& v, double* w) const {
    for (int i = 0; i < size(); i += 4) {
      for (int k = i; k < i + 4; k += 2) {
        Store(SumPairs(Dot<kPadded>(members_[k].m.data(), v.data()),
                       Dot<kPadded>(members_[k + 1].m.data(), v.data())),
              w + k);
      }
    }
  }

  /// z -= M'r, r padded with zeros.
  void Subtract(const double* r, V& z) const {
    for (int i = 0; i < size(); i += 4) {
      z -= (r[i] * members_[i].m + r[i + 1] * members_[i + 1].m) +
           (r[i + 2] * members_[i + 2].m + r[i + 3] * members_[i + 3].m);
    }
  }

  Member members_[kStride];
  Factor factor_;
  double lambda_[kStride] = {};      ///< multipliers
  double d_[kStride] = {};           ///< of the members, side by side; zeros behind them
  double falling_m2_[kStride] = {};  ///< |m|^2 of inequalities, 0 of equalities; likewise
  double w_[kStride] = {};           ///< room
};

}  // namespace pipewright::qp
