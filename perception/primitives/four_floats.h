// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "perception/primitives/config.h"

namespace pipewright {

/// Four numbers side by side (SSE2, NEON), and what a comparison of them gives: −1 true, 0 false.
using Floats [[gnu::vector_size(16)]] = float;
using Masks [[gnu::vector_size(16)]] = std::int32_t;
inline constexpr int kLanes = 4;

/// From and to anywhere in an array, aligned or not.
[[gnu::always_inline]] inline Floats Load(const float* from) {
  Floats to;
  std::memcpy(&to, from, sizeof to);
  return to;
}
[[gnu::always_inline]] inline void Store(const Floats& from, float* to) {
  std::memcpy(to, &from, sizeof from);
}

inline Floats Fill(float value) { return Floats{value, value, value, value}; }
inline Floats SquareRoot(const Floats& v) {
  return Floats{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
}
inline Floats Absolute(const Floats& v) { return v < -v ? -v : v; }
inline Floats Greater(const Floats& a, const Floats& b) { return a > b ? a : b; }

inline bool Any(const Masks& masks) {
  using Halves [[gnu::vector_size(16)]] = std::int64_t;
  const Halves halves = reinterpret_cast<Halves>(masks);
  return (halves[0] | halves[1]) != 0;
}
inline float Sum(const Floats& v) { return (v[0] + v[1]) + (v[2] + v[3]); }
inline int Sum(const Masks& v) { return v[0] + v[1] + v[2] + v[3]; }

/// Of four bytes of an array.
inline Masks Widen(const std::uint8_t* from) { return Masks{from[0], from[1], from[2], from[3]}; }

/// The points k ... k + 3, those from `end` on being the last; which are before `end`.
struct FourReadings {
  FourReadings(const Eigen::Vector3f* points, int k, int end) : there(Masks{0, 1, 2, 3} < end - k) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const Eigen::Vector3f& p = points[k + lane < end ? k + lane : end - 1];
      x[lane] = p.x(), y[lane] = p.y(), z[lane] = p.z();
    }
  }
  Floats x, y, z;
  Masks there;
};

/// σ(1/z)² and σ(1/z) of four readings: see DepthNoise.
inline Floats VarianceInverse(const Floats& inverse_z_1pm, const DepthNoise& noise) {
  const auto c2 = static_cast<float>(noise.c_1pm * noise.c_1pm);
  const auto step2 = static_cast<float>(noise.step_m * noise.step_m / 12);
  const Floats i2 = inverse_z_1pm * inverse_z_1pm;
  return c2 + step2 * i2 * i2;
}
inline Floats SigmaInverse(const Floats& inverse_z_1pm, const DepthNoise& noise) {
  return SquareRoot(VarianceInverse(inverse_z_1pm, noise));
}

}  // namespace pipewright
