// SPDX-License-Identifier: MIT
#include "tests/bench/faults/outcome.h"

#include <algorithm>
#include <cmath>

namespace pipewright::bench {
namespace {

/// P(at most k of n) at probability p.
double AtMost(std::uint64_t k, std::uint64_t n, double p) {
  double sum = 0;
  for (std::uint64_t i = 0; i <= k; ++i) {
    const auto x = static_cast<double>(i);
    const auto all = static_cast<double>(n);
    sum += std::exp(std::lgamma(all + 1) - std::lgamma(x + 1) - std::lgamma(all - x + 1) +
                    x * std::log(p) + (all - x) * std::log1p(-p));
  }
  return sum;
}

}  // namespace

double UpperBound95(std::uint64_t bad, std::uint64_t n) {
  if (bad >= n) {
    return 1;
  }
  if (bad == 0) {
    return std::min(1.0, 3.0 / static_cast<double>(n));
  }
  double lo = 0;
  double hi = 1;
  for (int i = 0; i < 60; ++i) {
    const double p = (lo + hi) / 2;
    (AtMost(bad, n, p) > 0.05 ? lo : hi) = p;
  }
  return hi;
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) {
    return 0;
  }
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(q * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace pipewright::bench
