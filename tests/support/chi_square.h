// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

namespace pipewright::test {

/// P(X <= x) of chi-square with 1 to 5 degrees of freedom, in closed form.
inline double ChiSquareCdf(double x, int dof) {
  assert(1 <= dof && dof <= 5);
  if (x <= 0) {
    return 0;
  }
  const double tail = std::exp(-x / 2);
  const double odd = std::erf(std::sqrt(x / 2));
  const double term = std::sqrt(2 * x / std::numbers::pi) * tail;
  const double cdf[] = {odd, 1 - tail, odd - term, 1 - tail * (1 + x / 2),
                        odd - term * (1 + x / 3)};
  return cdf[dof - 1];
}

/// The x with ChiSquareCdf(x) = p, by bisection.
inline double ChiSquareQuantile(double p, int dof) {
  double lo = 0;
  double hi = 200;
  for (int k = 0; k < 80; ++k) {
    const double middle = (lo + hi) / 2;
    (ChiSquareCdf(middle, dof) < p ? lo : hi) = middle;
  }
  return hi;
}

/// A figure of a sample and the two-sided 99 % band it lies in when the sample is what it claims.
struct Banded {
  double value = 0;
  double lo = 0;
  double hi = 0;

  bool within() const { return lo <= value && value <= hi; }
};

inline constexpr double kTwoSided99 = 2.5758;   ///< the standard normal's quantile 0.995
inline constexpr double kTwoSided999 = 3.2905;  ///< and 0.9995

/// Whether normalised errors squared are chi-square: mean and quantiles 0.5, 0.9, 0.99.
///
///   mean       dof ± 2.58 sqrt(2 dof / N)
///   quantiles  the order statistic p of N draws has rank p ± 2.58 sqrt(p (1 − p) / N)
struct Calibration {
  int dof = 0;
  long count = 0;
  Banded mean;
  Banded p50;
  Banded p90;
  Banded p99;

  bool within() const {
    return count > 0 && mean.within() && p50.within() && p90.within() && p99.within();
  }
};

inline Calibration Calibrate(std::vector<double> nees, int dof, double sigmas = kTwoSided99) {
  Calibration out;
  out.dof = dof;
  out.count = static_cast<long>(nees.size());
  if (nees.empty()) {
    return out;
  }
  std::sort(nees.begin(), nees.end());
  const auto n = static_cast<double>(nees.size());
  double sum = 0;
  for (const double x : nees) {
    sum += x;
  }
  const double spread = sigmas * std::sqrt(2 * dof / n);
  out.mean = {sum / n, dof - spread, dof + spread};
  const auto quantile = [&](double p) {
    const double rank = sigmas * std::sqrt(p * (1 - p) / n);
    return Banded{nees[static_cast<std::size_t>(p * (n - 1))],
                  ChiSquareQuantile(std::max(0.0, p - rank), dof),
                  ChiSquareQuantile(std::min(1.0, p + rank), dof)};
  };
  out.p50 = quantile(0.5);
  out.p90 = quantile(0.9);
  out.p99 = quantile(0.99);
  return out;
}

}  // namespace pipewright::test
