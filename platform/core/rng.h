// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>

namespace pipewright {

/// Seeded random numbers that are the same on every machine and compiler.
///
/// xoshiro256** 1.0 (Blackman, Vigna: Scrambled linear pseudorandom number generators, 2021), its
/// state filled by splitmix64. 32 bytes, no heap. std's distributions are not used: the standard
/// does not fix what they return.
class Rng {
 public:
  /// Streams of one seed are independent for all practical purposes.
  explicit constexpr Rng(std::uint64_t seed, std::uint64_t stream = 0) {
    std::uint64_t x = seed ^ (stream * 0x9E3779B97F4A7C15U + 0x632BE59BD9B4E019U);
    for (std::uint64_t& word : state_) {
      x += 0x9E3779B97F4A7C15U;
      std::uint64_t z = x;
      z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
      z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
      word = z ^ (z >> 31);
    }
  }

  constexpr std::uint64_t Next() {
    const std::uint64_t result = Rotl(state_[1] * 5, 7) * 9;
    const std::uint64_t t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = Rotl(state_[3], 45);
    return result;
  }

  /// Uniform in [0, 1), 53 bits.
  constexpr double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }

  constexpr double Uniform(double lo, double hi) { return lo + (hi - lo) * Uniform(); }

  /// Uniform in {0, ..., n - 1}; n > 0. Bias below n / 2^32.
  constexpr int Index(int n) {
    return static_cast<int>(((Next() >> 32) * static_cast<std::uint64_t>(n)) >> 32);
  }

  /// Standard normal, by Marsaglia's polar method.
  double Normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double a = 0;
    double b = 0;
    double s = 0;
    do {
      a = Uniform(-1, 1);
      b = Uniform(-1, 1);
      s = a * a + b * b;
    } while (s >= 1 || s == 0);
    const double scale = std::sqrt(-2 * std::log(s) / s);
    spare_ = b * scale;
    has_spare_ = true;
    return a * scale;
  }

 private:
  static constexpr std::uint64_t Rotl(std::uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }

  std::uint64_t state_[4]{};
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace pipewright
