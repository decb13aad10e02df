// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/qp/qp.h"
#include "ctrl/qp/simd.h"

namespace pipewright::qp {

/// Rows are measured in blocks of so many; arrays have room for whole blocks.
inline constexpr int kRowBlock = 8;

/// What MeasureRows found besides the misses.
struct RowMisses {
  double worst;  ///< the largest miss, -inf for no rows
  bool finite;   ///< every product was a number
};

template <typename Rows, int n, int stride>
[[gnu::always_inline]] inline RowMisses MeasureRowsBy(const double* A, int rows, const double* x,
                                                      const double* lo, const double* hi,
                                                      double* missed, double* most) {
  constexpr int kWidth = sizeof(Rows) / sizeof(double);
  constexpr int kRegisters = kRowBlock / kWidth;
  double worst = -kInfinity;
  Rows probe = {};  // 0 unless some product is no number
  for (int i = 0; i < rows; i += kRowBlock) {
    Rows y[kRegisters];
    Rows a;
    for (int r = 0; r < kRegisters; ++r) {
      Load(A + i + r * kWidth, a);
      y[r] = a * x[0];
    }
    for (int j = 1; j < n; ++j) {
      for (int r = 0; r < kRegisters; ++r) {
        Load(A + j * stride + i + r * kWidth, a);
        y[r] += a * x[j];
      }
    }
    Rows block = Rows{} - kInfinity;
    for (int r = 0; r < kRegisters; ++r) {
      Rows low;
      Rows high;
      Load(lo + i + r * kWidth, low);
      Load(hi + i + r * kWidth, high);
      const Rows over = y[r] - high;
      const Rows under = low - y[r];
      const Rows v = over > under ? over : under;
      Store(v, missed + i + r * kWidth);
      block = v > block ? v : block;
    }
    if (i + kRowBlock <= rows) {
      for (int r = 0; r < kRegisters; ++r) {
        probe += y[r] * 0;
      }
    } else {  // past the last row lies what an earlier problem left
      block = Rows{} - kInfinity;
      for (int k = 0; k < kRowBlock; ++k) {
        if (k < rows - i) {
          probe[0] += y[k / kWidth][k % kWidth] * 0;
          block[0] = missed[i + k] > block[0] ? missed[i + k] : block[0];
        } else {
          missed[i + k] = -kInfinity;
        }
      }
    }
    double largest = block[0];
    for (int k = 1; k < kWidth; ++k) {
      largest = block[k] > largest ? block[k] : largest;
    }
    most[i / kRowBlock] = largest;
    worst = largest > worst ? largest : worst;
  }
  double sum = 0;
  for (int k = 0; k < kWidth; ++k) {
    sum += probe[k];
  }
  return {worst, sum == 0};
}

#if defined(__x86_64__)
template <int n, int stride>
[[gnu::target("avx2")]] RowMisses MeasureRowsByFour(const double* A, int rows, const double* x,
                                                    const double* lo, const double* hi,
                                                    double* missed, double* most) {
  return MeasureRowsBy<Four, n, stride>(A, rows, x, lo, hi, missed, most);
}
inline const bool kHasFour = __builtin_cpu_supports("avx2");
#endif

/// By how much x misses each of the first `rows` rows: missed_i = max(a_i'x - hi_i, lo_i - a_i'x),
/// and per block the largest of them. A is column-major, n columns `stride` apart. Past the last
/// row missed_i is -inf, whatever stands there.
///
/// n rows multiply-adds and as many doubles read. Each a_i'x is one sum in the order of the
/// columns, so its bits do not depend on how many rows a register takes: x86-64 processors that
/// have AVX2 use it.
template <int n, int stride>
RowMisses MeasureRows(const double* A, int rows, const double* x, const double* lo,
                      const double* hi, double* missed, double* most) {
#if defined(__x86_64__)
  if (kHasFour) {
    return MeasureRowsByFour<n, stride>(A, rows, x, lo, hi, missed, most);
  }
#endif
  return MeasureRowsBy<Two, n, stride>(A, rows, x, lo, hi, missed, most);
}

/// What CopyLimits saw of the limits.
struct LimitFlaws {
  bool bad;    ///< lo > hi, an infinity on the wrong side, no number, or a price not >= 0
  bool equal;  ///< some lo = hi
};

/// Copies lo and hi of the first `rows` rows, and looks at them and the prices on the way.
inline LimitFlaws CopyLimits(const double* lo, const double* hi, const double* price, int rows,
                             double* to_lo, double* to_hi) {
  using Mask = decltype(Two{} >= Two{});  // all ones or all zeros
  Mask good = ~Mask{};
  Mask equal{};
  int i = 0;
  for (; i + 2 <= rows; i += 2) {
    Two low;
    Two high;
    Two cost;
    Load(lo + i, low);
    Load(hi + i, high);
    Load(price + i, cost);
    const Two gap = high - low;  // no number for inf, inf
    good &= (gap >= 0) & (cost >= 0);
    equal |= gap == 0;
    Store(low, to_lo + i);
    Store(high, to_hi + i);
  }
  LimitFlaws flaws{(good[0] & good[1]) == 0, (equal[0] | equal[1]) != 0};
  for (; i < rows; ++i) {
    const double gap = hi[i] - lo[i];
    flaws.bad |= !(gap >= 0) || !(price[i] >= 0);
    flaws.equal |= gap == 0;
    to_lo[i] = lo[i];
    to_hi[i] = hi[i];
  }
  return flaws;
}

}  // namespace pipewright::qp
