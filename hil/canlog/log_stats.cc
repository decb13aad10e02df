// SPDX-License-Identifier: MIT
#include "hil/canlog/log_stats.h"

#include <algorithm>
#include <cmath>

#include "platform/can/bits.h"

namespace pipewright::hil {
double PeriodStats::deviation_s() const {
  return count_ > 1 ? 1e-9 * std::sqrt(squares_ / static_cast<double>(count_ - 1)) : 0;
}

void FrameStats::Add(const LogFrame& frame, std::uint32_t frame_bits) {
  ++frames;
  remote += frame.remote ? 1 : 0;
  fd += frame.fd ? 1 : 0;
  errors += frame.error ? 1 : 0;
  payload_bytes += static_cast<std::uint64_t>(frame.payload_bytes());
  bits += frame_bits;
  if (!frame.stamped) {
    return;
  }
  if (stamped > 0) {
    periods.Add(frame.stamp_ns - last_ns);
    backward += frame.stamp_ns < last_ns ? 1 : 0;
  } else {
    first_ns = frame.stamp_ns;
  }
  last_ns = frame.stamp_ns;
  ++stamped;
}

std::optional<double> FrameStats::rate_hz() const {
  if (stamped < 2 || last_ns <= first_ns) {
    return std::nullopt;
  }
  return static_cast<double>(stamped - 1) / span_s();
}

std::optional<double> FrameStats::load(double bits_per_s, const FrameStats& channel) const {
  if (channel.last_ns <= channel.first_ns) {
    return std::nullopt;
  }
  return static_cast<double>(bits) / (bits_per_s * channel.span_s());
}

LogStats::LogStats(bool count_bits) : count_bits_(count_bits) {}

void LogStats::Add(std::span<const LogFrame> frames) {
  for (const LogFrame& frame : frames) {
    const bool on_wire = count_bits_ && !frame.fd && !frame.error;
    const auto bits =
        on_wire ? static_cast<std::uint32_t>(can::FrameBits(ClassicFrame(frame))) : 0U;
    all_.Add(frame, bits);
    if (channels_.size() <= frame.channel) {
      channels_.resize(frame.channel + std::size_t{1});
    }
    channels_[frame.channel].Add(frame, bits);
    FrameStats* const id = ids_.Find(KeyOf(frame));
    if (id != nullptr) {
      id->Add(frame, bits);
    } else {
      ++beyond_;
    }
  }
}

std::vector<LogStats::IdStats> LogStats::Sorted() const {
  std::vector<IdStats> sorted = ids_.entries();
  std::sort(sorted.begin(), sorted.end(),
            [](const IdStats& a, const IdStats& b) { return a.key < b.key; });
  return sorted;
}

}  // namespace pipewright::hil
