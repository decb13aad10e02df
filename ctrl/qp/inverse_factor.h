// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <utility>

#include "ctrl/qp/qp.h"

namespace pipewright::qp {

/// Lengths are rounded up to whole SSE2/NEON registers; what is added is always zero.
constexpr int Padded(int n) { return (n + 1) / 2 * 2; }

template <int n>
using PaddedVec = Eigen::Matrix<double, Padded(n), 1>;

/// A soft row taken for active from the start: instead of joining the working set its cost
/// w/2 (a'x - b)^2 joins H and g, which is cheaper. Its multiplier is w (a'x - b). When that turns
/// negative the row leaves: a member a'x + mu / w <= b, mu >= 0, takes the term back out, for at
/// the optimum over mu its own multiplier is mu = -w (a'x - b).
template <int n>
struct FoldedRow {
  int name;  ///< row index
  int side;  ///< +1: at the upper limit, -1: at the lower one
  bool out;  ///< taken back out
  double w;  ///< twice the price
  double b;
  PaddedVec<n> a;

  double Multiplier(const PaddedVec<n>& x) const { return w * (a.dot(x) - b); }
};

/// The lower triangular J (n x n) with H^-1 = J'J, so |J a| measures a in the metric of the QP.
template <int n>
class InverseFactor {
 public:
  /// Of H + sum over the folded rows of w a a' = L D L' without square roots on the critical path,
  /// then J = D^-1/2 L^-1, built along. Only H's lower triangle counts. False when H is not
  /// positive definite to rounding, or not a number. n^3 / 2 multiply-adds in vector registers, n^2
  /// / 2 a folded row.
  bool Compute(const Mat<n, n>& H, const FoldedRow<n>* folded, int count) {
    PaddedVec<n> left[n];  // what is left of H, then one column of D L at a time
    PaddedVec<n> scale = PaddedVec<n>::Zero();
    for (int j = 0; j < n; ++j) {
      left[j][Padded(n) - 1] = 0;
      left[j].template head<n>() = H.col(j);  // what stands above the diagonal counts for nothing
    }
    for (int k = 0; k < count; ++k) {
      const FoldedRow<n>& row = folded[k];
      ForEach([&]<int j>() { Subtract<j>(-row.w * row.a[j], row.a, left[j]); });
    }
    bool definite = true;
    ForEach([&]<int j>() {
      const double pivot = left[j][j];
      definite &= pivot > kSmallestPivot * H(j, j) && pivot < kInfinity;
      const double inverse = 1 / pivot;
      scale[j] = std::sqrt(inverse);
      PaddedVec<n> l = left[j] * inverse;
      l.template head<j + 1>().setZero();  // rows that took part to keep whole registers
      for (int k = j + 1; k < n; ++k) {
        Subtract<j + 1>(l[k], left[j], left[k]);
      }
      column_[j] = -l;  // L^-1 e_j so far
      column_[j][j] = 1;
      for (int c = 0; c < j; ++c) {
        Subtract<j>(column_[c][j], l, column_[c]);
      }
    });
    if (!definite) {
      return false;
    }
    for (int c = 0; c < n; ++c) {
      column_[c].array() *= scale.array();
    }
    return true;
  }

  /// J e_j.
  const PaddedVec<n>& Column(int j) const { return column_[j]; }

  /// J a.
  PaddedVec<n> Apply(const PaddedVec<n>& a) const {
    PaddedVec<n> y[2] = {PaddedVec<n>::Zero(), PaddedVec<n>::Zero()};
    ForEach([&]<int j>() { Subtract<j>(-a[j], column_[j], y[j % 2]); });
    return y[0] + y[1];
  }

  /// J'z.
  PaddedVec<n> ApplyTransposed(const PaddedVec<n>& z) const {
    PaddedVec<n> x = PaddedVec<n>::Zero();
    ForEach([&]<int j>() {
      constexpr int kTop = j / 2 * 2;
      x[j] = column_[j].template tail<Padded(n) - kTop>().dot(z.template tail<Padded(n) - kTop>());
    });
    return x;
  }

 private:
  static constexpr double kSmallestPivot = 1e-15;

  /// body<0>() ... body<n - 1>(): the number is a constant there, so that loops have fixed ends.
  template <typename Body>
  static void ForEach(Body body) {
    [&body]<int... j>(std::integer_sequence<int, j...>) { (body.template operator()<j>(), ...); }
    (std::make_integer_sequence<int, n>{});
  }

  /// to -= f from, from the pair on that holds row `first`: above, `from` counts for nothing.
  template <int first>
  static void Subtract(double f, const PaddedVec<n>& from, PaddedVec<n>& to) {
    if constexpr (first < n) {
      constexpr int kTop = first / 2 * 2;
      to.template tail<Padded(n) - kTop>() -= f * from.template tail<Padded(n) - kTop>();
    }
  }

  PaddedVec<n> column_[n];
};

}  // namespace pipewright::qp
