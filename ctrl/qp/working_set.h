// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>

#include "ctrl/qp/inverse_factor.h"

namespace pipewright::qp {

/// The constraints held active, and a factor of their Gram matrix
///
///   S = M M' + diag(d) = L diag(D) L'      row i of M: m_i = J a_i,  d_i = 1/(2 price_i) or 0
///
/// a_i carries the sign that makes the constraint a_i'x - d_i lambda_i <= b_i. S is only a tool:
/// every pivot comes from an explicit residual (Project), refined once when digits cancel, so the
/// factor is as good as one by orthogonal transformations (corrected semi-normal equations,
/// [Bjoerck 1987]) although it costs half and holds soft rows without growing m_i.
template <int n, int kMax>
class WorkingSet {
 public:
  using V = PaddedVec<n>;

  struct Member {
    int name = 0;  ///< row index, or m + j for the bound of variable j
    int side = 0;  ///< +1: at the upper limit, -1: at the lower one
    bool equality = false;
    double d = 0;
    double b = 0;
    double lambda = 0;
    V a;
    V m;
    double m2 = 0;  ///< |m|^2
  };

  /// The residual of a candidate constraint against the set.
  struct Projection {
    V z;                ///< m_p - M'r: what is new in m_p
    double r[kMax];     ///< S^-1 M m_p: how the set's multipliers fall as the candidate's grows
    double l[kMax];     ///< the new row of L
    double w[kMax];     ///< room to refine in
    double pivot = 0;   ///< |z|^2 + sum d_i r_i^2 + d_p
    double noise2 = 0;  ///< r_i^2 |m_i|^2 below this is rounding
    bool dependent = false;  ///< a_p is a combination of the set, to rounding
  };

  int size() const { return size_; }
  bool full() const { return size_ == kMax; }
  void clear() { size_ = 0; }
  const Member& operator[](int i) const { return members_[i]; }
  Member& operator[](int i) { return members_[i]; }

  void Project(const Member& candidate, Projection& p) const {
    p.z = candidate.m;
    for (int i = 0; i < size_; ++i) {
      p.l[i] = members_[i].m.dot(candidate.m);
    }
    ForwardSolve(p.l, p.l);
    BackwardSolve(p.l, p.r);
    for (int i = 0; i < size_; ++i) {
      p.z -= p.r[i] * members_[i].m;
    }
    double z2 = p.z.squaredNorm();
    double scale2 = candidate.m2;
    if (z2 < kCancelled * candidate.m2) {
      Refine(p);
      z2 = p.z.squaredNorm();
      for (int i = 0; i < size_; ++i) {
        scale2 += p.r[i] * p.r[i] * members_[i].m2;
      }
    }
    p.noise2 = kRounding * kRounding * scale2;
    p.pivot = z2 + candidate.d;
    for (int i = 0; i < size_; ++i) {
      p.pivot += members_[i].d * p.r[i] * p.r[i];
    }
    p.dependent = p.pivot <= p.noise2;
  }

  /// Adds a constraint with the projection computed for it against the present set.
  void Append(const Member& member, const Projection& p) {
    assert(size_ < kMax && !p.dependent);
    members_[size_] = member;
    double* row = Row(size_);
    for (int i = 0; i < size_; ++i) {
      row[i] = p.l[i];
    }
    D_[size_] = p.pivot;
    inverse_D_[size_] = 1 / p.pivot;
    ++size_;
  }

  /// Removes constraint `gone`: the trailing factor takes the rank-one update
  /// L D L' + D_gone v v', v = the column that goes ([Gill, Golub, Murray, Saunders 1974] C1).
  void Remove(int gone) {
    double v[kMax];
    double alpha = D_[gone];
    for (int i = gone + 1; i < size_; ++i) {
      const double* from = Row(i);
      v[i - 1] = from[gone];
      double* to = Row(i - 1);
      for (int c = 0, t = 0; c < i; ++c) {
        if (c != gone) {
          to[t++] = from[c];
        }
      }
      members_[i - 1] = members_[i];
      D_[i - 1] = D_[i];
    }
    --size_;
    for (int j = gone; j < size_; ++j) {
      const double p = v[j];
      const double d = D_[j];
      const double updated = d + alpha * p * p;
      const double inverse = 1 / updated;
      const double beta = alpha * p * inverse;
      alpha *= d * inverse;
      D_[j] = updated;
      inverse_D_[j] = inverse;
      for (int i = j + 1; i < size_; ++i) {
        double& l = Row(i)[j];
        v[i] -= p * l;
        l += beta * v[i];
      }
    }
  }

  /// x = S^-1 w; x may be w.
  void Solve(const double* w, double* x) const {
    ForwardSolve(w, x);
    BackwardSolve(x, x);
  }

 private:
  static constexpr double kCancelled = 1e-4;  ///< of |m_p|^2: below, z has lost digits
  static constexpr double kRounding = 1e-12;

  double* Row(int i) { return L_ + i * (i - 1) / 2; }
  const double* Row(int i) const { return L_ + i * (i - 1) / 2; }

  /// y = D^-1 L^-1 w; y may be w.
  void ForwardSolve(const double* w, double* y) const {
    for (int i = 0; i < size_; ++i) {
      const double* row = Row(i);
      double sum = w[i];
      for (int j = 0; j < i; ++j) {
        sum -= row[j] * y[j];
      }
      y[i] = sum;
    }
    for (int i = 0; i < size_; ++i) {
      y[i] *= inverse_D_[i];
    }
  }

  /// x = L'^-1 y; x may be y.
  void BackwardSolve(const double* y, double* x) const {
    for (int i = 0; i < size_; ++i) {
      x[i] = y[i];
    }
    for (int i = size_ - 1; i > 0; --i) {
      const double* row = Row(i);
      const double xi = x[i];
      for (int j = 0; j < i; ++j) {
        x[j] -= row[j] * xi;
      }
    }
  }

  /// One step of refinement of S r = M m_p: its residual is M z - d r.
  void Refine(Projection& p) const {
    for (int i = 0; i < size_; ++i) {
      p.w[i] = members_[i].m.dot(p.z) - members_[i].d * p.r[i];
    }
    Solve(p.w, p.w);
    for (int i = 0; i < size_; ++i) {
      p.r[i] += p.w[i];
      p.z -= p.w[i] * members_[i].m;
    }
  }

  Member members_[kMax];
  double L_[kMax * (kMax - 1) / 2 + 1];
  double D_[kMax];
  double inverse_D_[kMax];
  int size_ = 0;
};

}  // namespace pipewright::qp
