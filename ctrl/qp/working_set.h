// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cmath>

#include "ctrl/qp/inverse_factor.h"

namespace pipewright::qp {

/// The constraints held active, and the inverse of a factor of their Gram matrix
///
///   S = M M' + diag(d) = N^-1 diag(D) N'^-1      row i of M: m_i = J a_i,  d_i = 1/(2 price_i) or
///   0
///
/// a_i carries the sign that makes the constraint a_i'x - d_i lambda_i <= b_i. A member with d_i <
/// 0 takes a folded row's term back out of the cost (FoldedRow): S is then indefinite, but every
/// set of members poses a problem with one answer, so no leading minor of S is zero. N is unit
/// lower triangular; to have it rather than its inverse makes every solve two products of matrix
/// and vector, without the chain of dependent sums of a substitution, and the row that an added
/// constraint gives it is its projection, already at hand. S is only a tool: pivots that lose
/// digits come from an explicit residual (Project), refined once, so the factor is as good as one
/// by orthogonal transformations (corrected semi-normal equations, [Bjoerck 1987]) although it
/// costs half and holds soft rows without growing m_i.
template <int n, int kMax>
class WorkingSet {
 public:
  using V = PaddedVec<n>;
  static constexpr int kStride = (kMax + 3) / 4 * 4;

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

  /// A candidate constraint against the set. Arrays are padded to whole blocks.
  struct Projection {
    double r[kStride];  ///< S^-1 M m_p: how the set's multipliers fall as the candidate's grows
    V z;                ///< m_p - M'r: what is new in m_p
    double pivot = 0;   ///< m_p'm_p + d_p - (M m_p)'r = |z|^2 + sum d_i r_i^2 + d_p
    double noise2 = 0;  ///< r_i^2 |m_i|^2 below this is rounding
    bool dependent = false;  ///< a_p is a combination of the set, to rounding
  };

  int size() const { return size_; }
  bool full() const { return size_ == kMax; }
  void clear() { size_ = 0; }
  const Member& operator[](int i) const { return members_[i]; }
  double lambda(int i) const { return lambda_[i]; }
  double& lambda(int i) { return lambda_[i]; }
  /// Room for a candidate, lost with the next change of the set; appended from here it is not
  /// copied.
  Member& Next() { return members_[size_]; }

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

  /// lambda -= t r.
  void Fall(double t, const Projection& p) {
    for (int i = 0; i < size_; i += 4) {
      Four::Map(lambda_ + i) -= t * Four::Map(p.r + i);
    }
  }

  /// Adds a constraint, of multiplier lambda, with the projection computed for it against the
  /// present set.
  void Append(const Member& member, double lambda, const Projection& p) {
    assert(size_ < kMax && !p.dependent);
    if (&member != &members_[size_]) {
      members_[size_] = member;
    }
    double* const row = Row(size_);
    for (int i = 0; i < size_; ++i) {
      row[i] = -p.r[i];
    }
    row[size_] = 1;
    for (int i = size_ + 1; i < RoundUp(size_ + 1); ++i) {
      row[i] = 0;
    }
    for (int t = 0; t < n; ++t) {
      across_[t * kStride + size_] = member.m[t];
    }
    inverse_D_[size_] = 1 / p.pivot;
    lambda_[size_] = lambda;
    d_[size_] = member.d;
    ++size_;
    for (int i = size_; i < RoundUp(size_); ++i) {
      d_[i] = 0;
    }
  }

  /// Removes constraint `gone`. With g its row of N and p_i = -N_ig below it, the other rows lose
  /// their share, N_i + p_i g, and the trailing factor takes the rank-one update
  /// diag(D) + D_gone p p' = L~ diag(D~) L~' ([Gill, Golub, Murray, Saunders 1974] C1): rows of
  /// L~^-1 N follow one another as N_i - p_i s, s += beta_i N_i. @returns false when a pivot lost
  /// digits, as it may while S is indefinite
  bool Remove(int gone) {
    bool exact = true;
    double share[kStride];
    double sum[kStride] = {};
    const int blocks = RoundUp(size_);
    for (int c = 0; c < blocks; ++c) {
      share[c] = c < gone ? Row(gone)[c] : 0;
    }
    double alpha = 1 / inverse_D_[gone];
    for (int i = gone + 1; i < size_; ++i) {
      const double* const from = Row(i);
      double* const to = Row(i - 1);
      const double p = -from[gone];
      const double d = 1 / inverse_D_[i];
      const double updated = d + alpha * p * p;
      exact &= std::fabs(updated) > kLost * std::fabs(d);
      const double inverse = 1 / updated;
      const double beta = alpha * p * inverse;
      alpha *= d * inverse;
      for (int c = 0; c < gone; ++c) {
        to[c] = from[c] + p * (share[c] - sum[c]);
        sum[c] += beta * to[c];
      }
      for (int c = gone; c < i; ++c) {
        to[c] = from[c + 1] - p * sum[c];
        sum[c] += beta * to[c];
      }
      for (int c = i; c < RoundUp(i); ++c) {
        to[c] = 0;
      }
      members_[i - 1] = members_[i];
      lambda_[i - 1] = lambda_[i];
      d_[i - 1] = d_[i];
      inverse_D_[i - 1] = inverse;
    }
    --size_;
    d_[size_] = 0;
    for (int t = 0; t < n; ++t) {
      double* const row = across_ + t * kStride;
      for (int i = gone; i < size_; ++i) {
        row[i] = row[i + 1];
      }
    }
    return exact;
  }

  /// Factors S anew. @returns false when a member has become dependent on those before it
  bool Refactor(Projection& p) {
    const int size = size_;
    size_ = 0;
    for (int i = 0; i < size; ++i) {
      Project(members_[i], p);
      if (p.dependent) {
        return false;
      }
      Append(members_[i], lambda_[i], p);
    }
    return true;
  }

  /// x = S^-1 w; x may be w. Both have room for kStride.
  void Solve(const double* w, double* x) const {
    double y[kStride];
    ApplyScaled(w, y);
    ApplyTransposed(y, x);
  }

 private:
  using Four = Eigen::Array<double, 4, 1>;
  static constexpr double kApart = 1e-5;  ///< of its diagonal: less, and the pivot is formed anew
  static constexpr double kCancelled = 1e-5;  ///< of |m_p|^2: below, z has lost digits
  static constexpr double kLost = 0.1;  ///< of a pivot: with less left of it, S is factored anew
  static constexpr double kRounding = 1e-12;

  static constexpr int RoundUp(int i) { return (i + 3) / 4 * 4; }
  double* Row(int i) { return N_ + i * kStride; }
  const double* Row(int i) const { return N_ + i * kStride; }

  void Multipliers(const Member& candidate, Projection& p) {
    double* const w = w_;
    double y[kStride];
    for (int i = 0; i < size_; i += 4) {
      Four sum = Four::Map(across_ + i) * candidate.m[0];
      for (int t = 1; t < n; ++t) {
        sum += Four::Map(across_ + t * kStride + i) * candidate.m[t];
      }
      Four::Map(w + i) = sum;
    }
    for (int i = size_; i < RoundUp(size_); ++i) {
      w[i] = 0;
    }
    ApplyScaled(w, y);
    ApplyTransposed(y, p.r);
    Four known = Four::Zero();
    for (int i = 0; i < size_; i += 4) {
      known += Four::Map(w + i) * Four::Map(p.r + i);
    }
    p.pivot = candidate.m2 + candidate.d - known.sum();
  }

  void Complete(const Member& candidate, Projection& p) {
    p.z = candidate.m;
    for (int i = 0; i < size_; ++i) {
      p.z -= p.r[i] * members_[i].m;
    }
    double z2 = p.z.squaredNorm();
    double scale2 = candidate.m2;
    if (z2 + candidate.d < kCancelled * candidate.m2) {
      Refine(p);
      z2 = p.z.squaredNorm();
      for (int i = 0; i < size_; ++i) {
        scale2 += p.r[i] * p.r[i] * members_[i].m2;
      }
    }
    p.noise2 = kRounding * kRounding * scale2;
    Four softened = Four::Zero();
    for (int i = 0; i < size_; i += 4) {
      softened += Four::Map(d_ + i) * Four::Map(p.r + i).square();
    }
    p.pivot = z2 + candidate.d + softened.sum();
    p.dependent = candidate.d < 0 ? !(p.pivot < 0) : p.pivot <= p.noise2;
  }

  /// y = D^-1 N w, padded with zeros. Four rows at a time.
  void ApplyScaled(const double* w, double* y) const {
    for (int i = 0; i < size_; i += 4) {
      Four sum[4] = {Four::Zero(), Four::Zero(), Four::Zero(), Four::Zero()};
      const int rows = size_ - i < 4 ? size_ - i : 4;
      for (int c = 0; c < i; c += 4) {
        const Four v = Four::Map(w + c);
        for (int k = 0; k < 4; ++k) {
          sum[k] += Four::Map(Row(i + k) + c) * v;
        }
      }
      for (int k = 0; k < 4; ++k) {  // the block on the diagonal; w past the end is not read
        double tail = 0;
        for (int c = 0; k < rows && c <= k; ++c) {
          tail += Row(i + k)[i + c] * w[i + c];
        }
        y[i + k] = k < rows ? (sum[k].sum() + tail) * inverse_D_[i + k] : 0;
      }
    }
  }

  /// x = N'y, padded.
  void ApplyTransposed(const double* y, double* x) const {
    const int blocks = RoundUp(size_);
    for (int c = 0; c < blocks; c += 4) {
      Four sum = Four::Zero();
      for (int i = c; i < size_; ++i) {
        sum += Four::Map(Row(i) + c) * y[i];
      }
      Four::Map(x + c) = sum;
    }
  }

  /// One step of refinement of S r = M m_p: its residual is M z - d r.
  void Refine(Projection& p) {
    double* const w = w_;
    for (int i = 0; i < size_; ++i) {
      w[i] = members_[i].m.dot(p.z) - d_[i] * p.r[i];
    }
    Solve(w, w);
    for (int i = 0; i < size_; ++i) {
      p.r[i] += w[i];
      p.z -= w[i] * members_[i].m;
    }
  }

  Member members_[kMax + 1];
  double N_[kStride * kStride] = {};  ///< by rows, each padded with zeros to a block of four
  double across_[n * kStride] = {};   ///< M by columns
  double inverse_D_[kStride] = {};
  double lambda_[kStride] = {};  ///< multipliers
  double d_[kStride] = {};       ///< of the members, side by side
  double w_[kStride] = {};       ///< room
  int size_ = 0;
};

}  // namespace pipewright::qp
