// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>

// Registers of doubles. What is stored one by one cannot be loaded as a register at once: the load
// waits until the stores have left the core. So what a kernel reads by registers is written by
// them.
namespace pipewright::qp {

using Two [[gnu::vector_size(16)]] = double;   ///< SSE2, NEON
using Four [[gnu::vector_size(32)]] = double;  ///< AVX2; elsewhere two of the above

/// From and to anywhere in an array, aligned or not.
template <typename Register>
[[gnu::always_inline]] inline void Load(const double* from, Register& to) {
  std::memcpy(&to, from, sizeof to);
}
template <typename Register>
[[gnu::always_inline]] inline void Store(const Register& from, double* to) {
  std::memcpy(to, &from, sizeof from);
}

/// {a0 + a1, b0 + b1}.
inline Two SumPairs(const Two& a, const Two& b) {
  return __builtin_shufflevector(a, b, 0, 2) + __builtin_shufflevector(a, b, 1, 3);
}

/// Two numbers whose sum is a'b. `size` is even.
template <int size>
Two Dot(const double* a, const double* b) {
  Two sum = {};
  for (int t = 0; t < size; t += 2) {
    Two x;
    Two y;
    Load(a + t, x);
    Load(b + t, y);
    sum += x * y;
  }
  return sum;
}

}  // namespace pipewright::qp
