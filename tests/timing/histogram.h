// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace pipewright::timing {

/// How often each count from 0 on was met; what is kMost or more counts as kMost.
class Histogram {
 public:
  static constexpr std::size_t kMost = 4095;

  void Add(int count) { ++times_[std::min(static_cast<std::size_t>(count), kMost)]; }

  std::int64_t all() const {
    std::int64_t sum = 0;
    for (const std::int64_t n : times_) {
      sum += n;
    }
    return sum;
  }

  /// The smallest count that at least `share` of all do not exceed.
  std::size_t Percentile(double share) const {
    const double wanted = share * static_cast<double>(all());
    std::int64_t sum = 0;
    std::size_t i = 0;
    while (i < kMost && static_cast<double>(sum += times_[i]) < wanted) {
      ++i;
    }
    return i;
  }

  /// A line: how many, and p50, p99, p99.99 and the largest.
  void Print(const std::string& name) const {
    fmt::print("{:<28} {} counted, p50 {}, p99 {}, p99.99 {}, max {}\n", name, all(),
               Percentile(0.5), Percentile(0.99), Percentile(0.9999), Percentile(1));
  }

 private:
  std::vector<std::int64_t> times_ = std::vector<std::int64_t>(kMost + 1);
};

}  // namespace pipewright::timing
