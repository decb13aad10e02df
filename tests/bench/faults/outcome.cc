// SPDX-License-Identifier: MIT
#include "tests/bench/faults/outcome.h"

#include <algorithm>
#include <cmath>

namespace pipewright::bench {
double Quantile(std::vector<double> values, double q) {
  if (values.empty()) {
    return 0;
  }
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(q * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace pipewright::bench
