// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cmath>

#include "ctrl/qp/qp.h"
#include "ctrl/qp/simd.h"

namespace pipewright::qp {

/// S^-1 = N' diag(D)^-1 N of a symmetric S that grows and shrinks by a row and column at a time; no
/// leading minor of S is zero. N is unit lower triangular; to have it rather than its inverse makes
/// every solve two products of matrix and vector, without the chain of dependent sums of a
/// substitution, and the row that an appended one gives it is its projection, already at hand.
///
/// Everything is done in whole blocks of four. N is zero above its diagonal; past the end of the
/// last block that is in use N and D^-1 are zero, so what stands there in a vector adds nothing if
/// it is a number: loops have few lengths, which processors foretell.
template <int kMax>
class GramFactor {
 public:
  /// Of rows, and what vectors have room for: a block more than can be in use.
  static constexpr int kStride = (kMax + 3) / 4 * 4 + 4;

  int size() const { return size_; }
  void clear() { size_ = 0; }

  /// x = S^-1 w; x may be w. w is padded here, x comes padded with zeros. k^2 multiply-adds.
  void Solve(double* w, double* x) const {
    w[size_] = w[size_ + 1] = w[size_ + 2] = 0;
    SolveFinite(w, x);
  }

  /// As Solve, of a w that is padded with numbers, whichever.
  void SolveFinite(const double* w, double* x) const {
    double y[kStride];
    ApplyScaled(w, y);
    ApplyTransposed(y, x);
  }

  /// One row more. r: S^-1 times the row without its last; pivot: what that leaves of its last.
  void Append(const double* r, double pivot) {
    assert(size_ < kMax);
    const int last = size_ / 4 * 4;
    if (last == size_) {
      OpenBlock();
    }
    double* const row = Row(size_);
    for (int c = 0; c < last; c += 4) {
      Block::Map(row + c) = -Block::Map(r + c);
    }
    Block unit = Block::Map(kUnit[size_ - last]);
    if (size_ > last) {
      unit -= Block::Map(r + last);
    }
    Block::Map(row + last) = unit;
    inverse_D_[size_] = 1 / pivot;
    ++size_;
  }

  /// One row less. With g its row of N and p_i = -N_ig below it, the other rows lose their share,
  /// N_i + p_i g, and the trailing factor takes the rank-one update diag(D) + D_gone p p' =
  /// L~ diag(D~) L~' ([Gill, Golub, Murray, Saunders 1974] C1): rows of L~^-1 N follow one another
  /// as N_i - p_i s, s += beta_i N_i. @returns false when a pivot lost digits, as it may while S is
  /// indefinite
  bool Remove(int gone) {
    bool exact = true;
    double share[kStride];
    double sum[kStride];
    for (int c = 0; c < size_; c += 4) {
      Block::Map(share + c) = Block::Map(Row(gone) + c);
      Block::Map(sum + c).setZero();
    }
    share[gone] = 0;
    double alpha = 1 / inverse_D_[gone];
    for (int i = gone + 1; i < size_; ++i) {
      double* const from = Row(i);
      double* const to = Row(i - 1);
      const double p = -from[gone];
      const double d = 1 / inverse_D_[i];
      const double updated = d + alpha * p * p;
      exact &= std::fabs(updated) > kLost * std::fabs(d);
      const double inverse = 1 / updated;
      const double beta = alpha * p * inverse;
      alpha *= d * inverse;
      TakeOut(gone, i + 1, from);
      for (int c = 0; c < i; c += 4) {
        const Block row = Block::Map(from + c) + p * (Block::Map(share + c) - Block::Map(sum + c));
        Block::Map(sum + c) += beta * row;
        Block::Map(to + c) = row;
      }
      inverse_D_[i - 1] = inverse;
    }
    --size_;
    for (int c = 0; c <= size_; c += 4) {
      Block::Map(Row(size_) + c).setZero();
    }
    inverse_D_[size_] = 0;
    return exact;
  }

  /// Takes entry `gone` out of the first `size` of v, which are followed by zeros to the end of
  /// their block and one beyond.
  static void TakeOut(int gone, int size, double* v) {
    const int mixed = gone / 4 * 4;
    for (int c = mixed; c < mixed + 4; ++c) {
      v[c] = v[c < gone ? c : c + 1];
    }
    for (int c = mixed + 4; c < size; c += 4) {
      const Block next = Block::Map(v + c + 1);
      Block::Map(v + c) = next;
    }
  }

 private:
  using Block = Eigen::Array<double, 4, 1>;
  static constexpr double kLost = 0.1;  ///< of a pivot: with less left of it, S is factored anew
  static constexpr double kUnit[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};

  double* Row(int i) { return N_ + i * kStride; }
  const double* Row(int i) const { return N_ + i * kStride; }

  void OpenBlock() {
    const Block zero = Block::Zero();
    for (int i = size_; i < size_ + 4; ++i) {
      for (int c = 0; c <= size_; c += 4) {
        Block::Map(Row(i) + c) = zero;
      }
    }
    Block::Map(inverse_D_ + size_) = zero;
  }

  /// y = D^-1 N w, padded with zeros. Four rows at a time.
  void ApplyScaled(const double* w, double* y) const {
    for (int i = 0; i < size_; i += 4) {
      Two sum[4] = {};
      Two more[4] = {};
      for (int c = 0; c <= i; c += 4) {
        Two v[2];
        Load(w + c, v[0]);
        Load(w + c + 2, v[1]);
        for (int k = 0; k < 4; ++k) {
          Two row[2];
          Load(Row(i + k) + c, row[0]);
          Load(Row(i + k) + c + 2, row[1]);
          sum[k] += row[0] * v[0];
          more[k] += row[1] * v[1];
        }
      }
      for (int k = 0; k < 4; k += 2) {
        Two scale;
        Load(inverse_D_ + i + k, scale);
        Store(scale * SumPairs(sum[k] + more[k], sum[k + 1] + more[k + 1]), y + i + k);
      }
    }
  }

  /// x = N'y, both padded with zeros.
  void ApplyTransposed(const double* y, double* x) const {
    for (int c = 0; c < size_; c += 4) {
      Block sum = Block::Zero();
      for (int i = c; i < size_; i += 4) {
        sum += (Block::Map(Row(i) + c) * y[i] + Block::Map(Row(i + 1) + c) * y[i + 1]) +
               (Block::Map(Row(i + 2) + c) * y[i + 2] + Block::Map(Row(i + 3) + c) * y[i + 3]);
      }
      Block::Map(x + c) = sum;
    }
  }

  double N_[kStride * kStride] = {};  ///< by rows
  double inverse_D_[kStride] = {};
  int size_ = 0;
};

}  // namespace pipewright::qp
