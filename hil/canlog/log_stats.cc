// SPDX-License-Identifier: MIT
#include "hil/canlog/log_stats.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "platform/can/bits.h"

namespace pipewright::hil {
namespace {

constexpr std::size_t kSlots = 4 * LogStats::kMostIds;
constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15;
constexpr int kSlotShift = 64 - 18;
static_assert(kSlots == std::size_t{1} << (64 - kSlotShift));

}  // namespace

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

LogStats::LogStats(bool count_bits) : count_bits_(count_bits), slots_(kSlots) {}

FrameStats* LogStats::Find(const LogFrame& frame) {
  const std::uint64_t key = std::uint64_t{frame.channel} << 32 | (frame.error ? 1U << 30 : 0) |
                            (frame.extended ? 1U << 31 : 0) | frame.id;
  for (std::size_t slot = key * kGolden >> kSlotShift;; slot = (slot + 1) % kSlots) {
    if (slots_[slot] == 0) {
      if (ids_.size() == kMostIds) {
        return nullptr;
      }
      ids_.push_back({frame.channel, frame.id, frame.extended, frame.error, {}});
      slots_[slot] = static_cast<std::uint32_t>(ids_.size());
      return &ids_.back().stats;
    }
    IdStats& id = ids_[slots_[slot] - 1];
    if (id.id == frame.id && id.channel == frame.channel && id.extended == frame.extended &&
        id.error == frame.error) {
      return &id.stats;
    }
  }
}

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
    FrameStats* const id = Find(frame);
    if (id != nullptr) {
      id->Add(frame, bits);
    } else {
      ++beyond_;
    }
  }
}

std::vector<IdStats> LogStats::Sorted() const {
  std::vector<IdStats> sorted = ids_;
  const auto key = [](const IdStats& s) {
    return std::tuple(s.channel, s.error, s.extended, s.id);
  };
  std::sort(sorted.begin(), sorted.end(),
            [&key](const IdStats& a, const IdStats& b) { return key(a) < key(b); });
  return sorted;
}

}  // namespace pipewright::hil
