// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <numeric>
#include <vector>

namespace pipewright::bench {

/// The least time of each part of some work, in seconds, over all passes: what else the machine
/// does disturbs a part, not the sum.
class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;

  template <typename Work>
  void Time(std::size_t part, Work work) {
    const Clock::time_point begin = Clock::now();
    work();
    const double took_s = std::chrono::duration<double>(Clock::now() - begin).count();
    least_s_.resize(std::max(least_s_.size(), part + 1), 1e30);
    least_s_[part] = std::min(least_s_[part], took_s);
  }
  double least_s() const { return std::accumulate(least_s_.begin(), least_s_.end(), 0.0); }

 private:
  std::vector<double> least_s_;
};

}  // namespace pipewright::bench
