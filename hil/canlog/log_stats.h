// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hil/canlog/id_table.h"
#include "hil/canlog/log_frame.h"

namespace pipewright::hil {

/// Mean and spread of times between neighbours, in one pass (Welford 1962).
class PeriodStats {
 public:
  void Add(std::int64_t period_ns) {
    ++count_;
    min_ns_ = period_ns < min_ns_ ? period_ns : min_ns_;
    max_ns_ = period_ns > max_ns_ ? period_ns : max_ns_;
    const double period = static_cast<double>(period_ns);
    const double before = period - mean_ns_;
    mean_ns_ += before / static_cast<double>(count_);
    squares_ += before * (period - mean_ns_);
  }
  std::uint64_t count() const { return count_; }
  /// Of no period: 0.
  double min_s() const { return count_ > 0 ? 1e-9 * static_cast<double>(min_ns_) : 0; }
  double max_s() const { return count_ > 0 ? 1e-9 * static_cast<double>(max_ns_) : 0; }
  double mean_s() const { return 1e-9 * mean_ns_; }
  /// Standard deviation of the periods: the jitter. Of the sample, n - 1.
  double deviation_s() const;

 private:
  std::uint64_t count_ = 0;
  std::int64_t min_ns_ = INT64_MAX;
  std::int64_t max_ns_ = INT64_MIN;
  double mean_ns_ = 0;
  double squares_ = 0;
};

/// Counts of one id on one channel, of a channel, or of all.
struct FrameStats {
  std::uint64_t frames = 0;
  std::uint64_t remote = 0;
  std::uint64_t fd = 0;
  std::uint64_t errors = 0;         ///< error messages
  std::uint64_t payload_bytes = 0;  ///< a remote frame has none
  std::uint64_t bits = 0;           ///< on the wire, of classic frames; 0 unless asked for
  std::uint64_t stamped = 0;
  std::uint64_t backward = 0;  ///< stamps below that of the frame before
  std::int64_t first_ns = 0;   ///< of the stamped ones, in the order of the log
  std::int64_t last_ns = 0;
  PeriodStats periods;

  void Add(const LogFrame& frame, std::uint32_t frame_bits);
  double span_s() const { return 1e-9 * static_cast<double>(last_ns - first_ns); }
  /// Frames a second: periods over the time they take; none when that is not above 0.
  std::optional<double> rate_hz() const;
  /// Share that the frames take of a bus of this bit rate in the time that `channel`, all frames of
  /// theirs, takes; none when that is not above 0.
  std::optional<double> load(double bits_per_s, const FrameStats& channel) const;
};

/// Statistics of a log, in memory that its ids and not its length take: of at most kMostIds, what
/// is beyond is counted.
class LogStats {
 public:
  using IdStats = IdTable<FrameStats>::Entry;
  static constexpr std::size_t kMostIds = IdTable<FrameStats>::kMost;

  /// @param count_bits  sum up the bits on the wire, stuff bits included
  explicit LogStats(bool count_bits);

  void Add(std::span<const LogFrame> frames);

  const FrameStats& all() const { return all_; }
  /// By channel number.
  const std::vector<FrameStats>& channels() const { return channels_; }
  /// By channel, then 11-bit ids, 29-bit ids, error messages.
  std::vector<IdStats> Sorted() const;
  std::uint64_t frames_beyond() const { return beyond_; }  ///< of ids for which there was no room

 private:
  bool count_bits_;
  FrameStats all_;
  std::vector<FrameStats> channels_;
  IdTable<FrameStats> ids_;
  std::uint64_t beyond_ = 0;
};

}  // namespace pipewright::hil
