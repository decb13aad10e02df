// SPDX-License-Identifier: MIT
#include "hil/report/series.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace pipewright::hil {

Sampler::Sampler(int max_points) : capacity_(static_cast<std::size_t>(max_points) / 2) {
  assert(max_points >= 4 && max_points % 4 == 0);
  buckets_.reserve(capacity_);
}

Sampler::Bucket Sampler::Merge(const Bucket& a, const Bucket& b) {
  if (a.gap) {
    return b;
  }
  Bucket merged = a;
  if (!b.gap && b.lo < a.lo) {
    merged.lo = b.lo;
    merged.t_lo_s = b.t_lo_s;
  }
  if (!b.gap && b.hi > a.hi) {
    merged.hi = b.hi;
    merged.t_hi_s = b.t_hi_s;
  }
  return merged;
}

void Sampler::Add(double t_s, double value) {
  const Bucket sample{t_s, value, t_s, value, !std::isfinite(value)};
  if (!buckets_.empty() && in_last_ < per_bucket_) {
    buckets_.back() = Merge(buckets_.back(), sample);
    ++in_last_;
    return;
  }
  if (buckets_.size() == capacity_) {
    const std::size_t half = capacity_ / 2;
    for (std::size_t i = 0; i < half; ++i) {
      buckets_[i] = Merge(buckets_[2 * i], buckets_[2 * i + 1]);
    }
    buckets_.resize(half);
    per_bucket_ *= 2;
  }
  buckets_.push_back(sample);
  in_last_ = 1;
}

Series Sampler::Take(std::string name) const {
  Series series;
  series.name = std::move(name);
  const auto point = [&series](double t_s, double value) {
    series.t_s.push_back(t_s);
    series.value.push_back(value);
  };
  for (const Bucket& b : buckets_) {
    if (b.gap) {
      point(b.t_lo_s, std::numeric_limits<double>::quiet_NaN());
    } else if (b.t_lo_s < b.t_hi_s) {
      point(b.t_lo_s, b.lo);
      point(b.t_hi_s, b.hi);
    } else if (b.t_hi_s < b.t_lo_s) {
      point(b.t_hi_s, b.hi);
      point(b.t_lo_s, b.lo);
    } else {
      point(b.t_lo_s, b.lo);
    }
  }
  return series;
}

Series Decimate(const Series& series, int max_points) {
  if (series.value.size() <= static_cast<std::size_t>(max_points)) {
    return series;
  }
  Sampler sampler(max_points);
  for (std::size_t i = 0; i < series.value.size(); ++i) {
    sampler.Add(series.t_s[i], series.value[i]);
  }
  return sampler.Take(series.name);
}

}  // namespace pipewright::hil
