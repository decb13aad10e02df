// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "platform/core/frames.h"

namespace pipewright::qp {

/// Lengths are rounded up to whole SSE2/NEON registers; what is added is always zero.
constexpr int Padded(int n) { return (n + 1) / 2 * 2; }

template <int n>
using PaddedVec = Eigen::Matrix<double, Padded(n), 1>;

/// The lower triangular J (n x n) with H^-1 = J'J, so |J a| measures a in the metric of the QP.
template <int n>
class InverseFactor {
 public:
  /// H = L D L' without square roots on the critical path, then J = D^-1/2 L^-1, built along.
  /// Only H's lower triangle is read. False when H is not positive definite to rounding, or not a
  /// number. n^3 multiply-adds in vector registers.
  bool Compute(const Mat<n, n>& H) {
    PaddedVec<n> column[n];  // what is left of H, then one column of L at a time
    PaddedVec<n> scale = PaddedVec<n>::Zero();
    for (int j = 0; j < n; ++j) {
      column[j].setZero();
      for (int i = j; i < n; ++i) {
        column[j][i] = H(i, j);
      }
    }
    for (int j = 0; j < n; ++j) {
      const double pivot = column[j][j];
      if (!(pivot > kSmallestPivot * H(j, j)) || !std::isfinite(pivot)) {
        return false;
      }
      const double inverse = 1 / pivot;
      scale[j] = std::sqrt(inverse);
      PaddedVec<n> l = column[j] * inverse;
      for (int i = 0; i <= j; ++i) {
        l[i] = 0;  // rows above the pivot were updated too, to keep whole registers
      }
      for (int k = j + 1; k < n; ++k) {
        column[k] -= l[k] * column[j];
      }
      column_[j] = -l;  // L^-1 e_j so far
      column_[j][j] = 1;
      for (int c = 0; c < j; ++c) {
        column_[c] -= column_[c][j] * l;
      }
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
    PaddedVec<n> y = column_[0] * a[0];
    for (int j = 1; j < n; ++j) {
      y += column_[j] * a[j];
    }
    return y;
  }

  /// J'z.
  PaddedVec<n> ApplyTransposed(const PaddedVec<n>& z) const {
    PaddedVec<n> x = PaddedVec<n>::Zero();
    for (int j = 0; j < n; ++j) {
      x[j] = column_[j].dot(z);
    }
    return x;
  }

 private:
  static constexpr double kSmallestPivot = 1e-15;

  PaddedVec<n> column_[n];
};

}  // namespace pipewright::qp
