// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>

#include "platform/core/time.h"

namespace pipewright {

/// A number of a configuration that can be reckoned with, in any unit of this program: not NaN, not
/// infinite, at most 1e9 in size, and zero or at least 1e-9, so that neither a square nor a
/// quotient of two leaves the normal numbers.
constexpr bool Usable(double x) {
  const double size = x < 0 ? -x : x;
  return size == 0 || (1e-9 <= size && size <= 1e9);  // written so that NaN fails
}

constexpr bool Usable(std::initializer_list<double> xs) {
  for (const double x : xs) {
    if (!Usable(x)) {
      return false;
    }
  }
  return true;
}

/// A duration of a configuration, zero or more: an hour at most, so that sums of some do not
/// overflow and none means "never".
constexpr bool Usable(Duration d) { return Duration::zero() <= d && d <= std::chrono::hours(1); }

}  // namespace pipewright
