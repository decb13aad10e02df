// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace pipewright::hil {

/// A signal over time. A value that is not finite is a gap.
struct Series {
  std::string name;
  std::vector<double> t_s;  ///< ascending, as many as value
  std::vector<double> value;
};

/// Thins a signal while it is recorded, so that a run of any length keeps its extremes in fixed
/// memory: samples fall into at most max_points/2 buckets of equal count, each of which keeps its
/// smallest and its largest value with their times. When all buckets are full, neighbours merge.
///
///   Sampler speed;
///   speed.Add(t_s, v_mps);           // every cycle; some nanoseconds
///   plot.series = {speed.Take("v")};
///
/// The global extremes are exact; any other value is wrong by at most one bucket in time. A bucket
/// without any finite value becomes a gap.
class Sampler {
 public:
  static constexpr int kMaxPoints = 1000;

  /// @param max_points  a multiple of 4
  explicit Sampler(int max_points = kMaxPoints);

  void Add(double t_s, double value);

  /// What has been recorded so far: at most max_points points, in the order of time.
  Series Take(std::string name) const;

 private:
  struct Bucket {
    double t_lo_s = 0;
    double lo = 0;
    double t_hi_s = 0;
    double hi = 0;
    bool gap = true;
  };
  static Bucket Merge(const Bucket& a, const Bucket& b);

  std::size_t capacity_;
  std::vector<Bucket> buckets_;
  long per_bucket_ = 1;
  long in_last_ = 0;
};

/// The same for a series that is there already.
Series Decimate(const Series& series, int max_points = Sampler::kMaxPoints);

}  // namespace pipewright::hil
