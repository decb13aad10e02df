// SPDX-License-Identifier: MIT
// Against brute force, which keeps every frame.
#include "hil/canlog/log_stats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "platform/can/bits.h"
#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

using namespace test;
/// All kinds, some without a time, some back in time, on three channels.
std::vector<LogFrame> Awkward(int count, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<LogFrame> frames = RandomFrames(count, seed);
  for (LogFrame& frame : frames) {
    frame.channel = static_cast<std::uint8_t>(rng.Index(3));
    frame.stamped = rng.Index(50) > 0;
    frame.stamp_ns -= rng.Index(10) == 0 ? 5'000'000 : 0;
    frame.remote = rng.Index(20) == 0;
    frame.error = !frame.extended && rng.Index(30) == 0;
    frame.fd = !frame.remote && !frame.error && rng.Index(20) == 0;
  }
  return frames;
}

void ExpectStats(const FrameStats& got, const std::vector<LogFrame>& frames) {
  std::uint64_t bytes = 0;
  std::uint64_t bits = 0;
  std::uint64_t errors = 0;
  std::vector<std::int64_t> stamps;
  for (const LogFrame& f : frames) {
    bytes += f.remote ? 0 : f.length;
    bits += f.fd || f.error ? 0 : static_cast<std::uint64_t>(can::FrameBits(ClassicFrame(f)));
    errors += f.error ? 1 : 0;
    if (f.stamped) {
      stamps.push_back(f.stamp_ns);
    }
  }
  EXPECT_EQ(got.frames, frames.size());
  EXPECT_EQ(got.payload_bytes, bytes);
  EXPECT_EQ(got.bits, bits);
  EXPECT_EQ(got.errors, errors);
  EXPECT_EQ(got.stamped, stamps.size());
  if (stamps.size() < 3) {
    return;
  }
  long double sum = 0;
  long double squares = 0;
  std::uint64_t backward = 0;
  std::int64_t least = INT64_MAX;
  std::int64_t most = INT64_MIN;
  const auto periods = static_cast<long double>(stamps.size() - 1);
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const std::int64_t period = stamps[i] - stamps[i - 1];
    sum += static_cast<long double>(period);
    backward += period < 0 ? 1 : 0;
    least = std::min(least, period);
    most = std::max(most, period);
  }
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const long double off = static_cast<long double>(stamps[i] - stamps[i - 1]) - sum / periods;
    squares += off * off;
  }
  EXPECT_EQ(got.backward, backward);
  EXPECT_EQ(got.first_ns, stamps.front());
  EXPECT_EQ(got.last_ns, stamps.back());
  // Doubles of nanoseconds: relative to the largest period.
  const double tolerance = 1e-12 * static_cast<double>(most) * 1e-9;
  EXPECT_DOUBLE_EQ(got.periods.min_s(), 1e-9 * static_cast<double>(least));
  EXPECT_DOUBLE_EQ(got.periods.max_s(), 1e-9 * static_cast<double>(most));
  EXPECT_NEAR(got.periods.mean_s(), static_cast<double>(1e-9L * sum / periods), tolerance);
  EXPECT_NEAR(got.periods.deviation_s(),
              static_cast<double>(1e-9L * std::sqrt(squares / (periods - 1))), 1e3 * tolerance);
}

TEST(LogStats, AreThoseOfBruteForce) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<LogFrame> frames = Awkward(2000, seed);
    LogStats stats(/*count_bits=*/true);
    stats.Add(std::span(frames).first(777));
    stats.Add(std::span(frames).subspan(777));
    std::map<IdKey, std::vector<LogFrame>> by_id;
    std::map<int, std::vector<LogFrame>> by_channel;
    for (const LogFrame& frame : frames) {
      by_id[KeyOf(frame)].push_back(frame);
      by_channel[frame.channel].push_back(frame);
    }
    ExpectStats(stats.all(), frames);
    for (const auto& [channel, its_frames] : by_channel) {
      ExpectStats(stats.channels()[static_cast<std::size_t>(channel)], its_frames);
    }
    const std::vector<LogStats::IdStats> sorted = stats.Sorted();
    ASSERT_EQ(sorted.size(), by_id.size());
    std::size_t i = 0;
    for (const auto& [key, its_frames] : by_id) {
      const LogStats::IdStats& id = sorted[i++];
      EXPECT_EQ(id.key, key);
      ExpectStats(id.value, its_frames);
    }
  }
}

TEST(LogStats, ReadRatesAndLoadsOffAKnownBus) {
  // 101 frames a hundredth of a second apart, each of 47 + 8 bits and 5 stuff bits: id 0, one byte
  // 0.
  std::vector<LogFrame> frames;
  for (int i = 0; i <= 100; ++i) {
    frames.push_back(DataFrame(0, {0}, 10'000'000LL * i));
  }
  LogStats stats(true);
  stats.Add(frames);
  const FrameStats& all = stats.all();
  EXPECT_DOUBLE_EQ(all.rate_hz().value(), 100);
  EXPECT_DOUBLE_EQ(all.load(500'000, all).value(),
                   101 * can::FrameBits(ClassicFrame(frames[0])) / 500'000.0);
  EXPECT_NEAR(all.periods.deviation_s(), 0, 1e-15);
  LogStats single(false);
  single.Add(std::span(frames).first(1));
  EXPECT_FALSE(single.all().rate_hz());
  EXPECT_FALSE(single.all().load(500'000, single.all()));
  EXPECT_EQ(single.all().periods.max_s(), 0);
}

TEST(LogStats, CountsFramesOfIdsForWhichThereIsNoRoom) {
  LogStats stats(false);
  std::vector<LogFrame> frame(1);
  frame[0] = DataFrame(0, {});
  frame[0].extended = true;
  for (std::size_t i = 0; i < LogStats::kMostIds + 10; ++i) {
    frame[0].id = static_cast<std::uint32_t>(i);
    stats.Add(frame);
  }
  EXPECT_EQ(stats.frames_beyond(), 10U);
  EXPECT_EQ(stats.all().frames, LogStats::kMostIds + 10);
  EXPECT_EQ(stats.Sorted().size(), LogStats::kMostIds);
}

}  // namespace
}  // namespace pipewright::hil
