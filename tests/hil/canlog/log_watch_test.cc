// SPDX-License-Identifier: MIT
// Logs made without a fault, then with one put in: found is that one and nothing else.
#include "hil/canlog/log_watch.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

using namespace test;
using Kind = FindingKind;

constexpr std::int64_t kMs = 1'000'000;

std::vector<Finding> Watch(std::vector<LogFrame> frames, const WatchConfig& config = {}) {
  std::vector<Finding> found;
  LogWatch watch(config, [&found](const Finding& finding) { found.push_back(finding); });
  const std::size_t half = frames.size() / 2;
  watch.Add(std::span(frames).first(half));
  watch.Add(std::span(frames).subspan(half));
  watch.End();
  return found;
}

/// Two seconds of a base that is told to drive, of an arm's node, and of an id in no table.
std::vector<LogFrame> Healthy() {
  std::vector<LogFrame> frames;
  for (int ms = 0; ms < 2000; ++ms) {
    const std::int64_t ns = kMs * (1'700'000'000'000 + ms);
    const int tick = ms / 20;
    if (ms % 20 == 0) {
      frames.push_back(DataFrame(0x111, {0, 100, 0, 0, 0, 0, 0, 0}, ns));
      frames.push_back(DataFrame(0x211, {0, 1, 1, 0, 0, 0, 0, tick & 0xFF}, ns + 1000));
    }
    if (ms % 10 == 0) {
      frames.push_back(DataFrame(0x080, {}, ns + 2000));
      frames.push_back(DataFrame(0x18F, {ms & 0xFF, ms >> 8}, ns + 3000));  // in no table
    }
    if (ms % 100 == 0) {
      frames.push_back(DataFrame(0x701, {5}, ns + 4000));
      frames.push_back(DataFrame(0x601, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}, ns + 5000));
      frames.push_back(DataFrame(0x581, {0x4B, 0x41, 0x60, 0, ms & 0xFF, 0, 0, 0}, ns + 300'000));
    }
  }
  std::stable_sort(frames.begin(), frames.end(),
                   [](const LogFrame& a, const LogFrame& b) { return a.stamp_ns < b.stamp_ns; });
  return frames;
}

/// Without frames of `id` from `from_ms` up to `to_ms`.
std::vector<LogFrame> Without(std::uint32_t id, int from_ms, int to_ms) {
  std::vector<LogFrame> frames = Healthy();
  const std::int64_t begin = frames.front().stamp_ns;
  std::erase_if(frames, [=](const LogFrame& f) {
    const std::int64_t at = f.stamp_ns - begin;
    return f.id == id && at >= kMs * from_ms && at < kMs * to_ms;
  });
  return frames;
}

/// The frame of `id` that comes first at or after `ms`.
std::vector<LogFrame>::iterator At(std::vector<LogFrame>& frames, std::uint32_t id, int ms) {
  const std::int64_t from = frames.front().stamp_ns + kMs * ms;
  return std::find_if(frames.begin(), frames.end(),
                      [=](const LogFrame& f) { return f.id == id && f.stamp_ns >= from; });
}

void ExpectOne(const std::vector<Finding>& found, Kind kind, std::uint32_t id, double seconds) {
  ASSERT_EQ(found.size(), 1U) << Name(found.empty() ? kind : found[1].kind);
  EXPECT_STREQ(Name(found[0].kind), Name(kind));
  EXPECT_EQ(found[0].key.id, id);
  EXPECT_NEAR(found[0].seconds, seconds, 1e-3);
}

TEST(LogWatch, FindsNothingInAHealthyLog) {
  EXPECT_TRUE(Watch(Healthy()).empty());
  EXPECT_TRUE(Watch({}).empty());
}

TEST(LogWatch, FindsGapsOfIdsByTheirPeriodInTheTablesOrByWhatItLearns) {
  ExpectOne(Watch(Without(0x080, 1000, 1030)), Kind::kGap, 0x080, 0.040);
  EXPECT_TRUE(Watch(Without(0x080, 1000, 1020)).empty());  // three periods are not more than three
  ExpectOne(Watch(Without(0x18F, 1000, 1030)), Kind::kGap, 0x18F, 0.040);
  ExpectOne(Watch(Without(0x080, 1900, 2000)), Kind::kGap, 0x080, 0.100);  // to the log's end
  EXPECT_EQ(Watch(Without(0x18F, 50, 120)).size(), 0U);  // not yet learned: not periodic at all
  EXPECT_EQ(Watch(Without(0x080, 1000, 1020), {.gap_factor = 2}).size(), 1U);
}

TEST(LogWatch, FindsTheBasesWatchdogRunOut) {
  const std::vector<Finding> found = Watch(Without(0x111, 1000, 1500));
  ExpectOne(found, Kind::kCommandExpired, 0x111, 0.520);
  EXPECT_EQ(found[0].code, 1U);  // it was told to move
  ExpectOne(Watch(Without(0x111, 1000, 1440)), Kind::kGap, 0x111, 0.460);
  ExpectOne(Watch(Without(0x111, 1000, 2000)), Kind::kCommandExpired, 0x111, 1.010);
}

TEST(LogWatch, FindsLostHeartbeatsAndRestarts) {
  ExpectOne(Watch(Without(0x701, 1000, 1300)), Kind::kHeartbeatLost, 0x701, 0.4);
  EXPECT_TRUE(Watch(Without(0x701, 1000, 1200)).empty());
  std::vector<LogFrame> frames = Healthy();
  At(frames, 0x701, 1000)->data[0] = 0;
  ExpectOne(Watch(frames), Kind::kRestart, 0x701, 0);
}

TEST(LogWatch, FindsCountsThatJumpRepeatOrGoBack) {
  const struct {
    int shift;
    Kind kind;
    std::uint32_t code;
  } cases[] = {{5, Kind::kCountJump, 5}, {-1, Kind::kCountRepeat, 0}, {-4, Kind::kCountBack, 3}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.shift);
    std::vector<LogFrame> frames = Healthy();
    for (auto f = At(frames, 0x211, 1000); f != frames.end(); ++f) {
      if (f->id == 0x211) {
        f->data[7] = static_cast<std::uint8_t>(f->data[7] + c.shift);
      }
    }
    const std::vector<Finding> found = Watch(frames);
    ExpectOne(found, c.kind, 0x211, 0.020);
    EXPECT_EQ(found[0].code, c.code);
  }
  std::vector<LogFrame> frames = Healthy();
  for (LogFrame& frame : frames) {
    frame.data[7] = frame.id == 0x211 ? 0 : frame.data[7];
  }
  EXPECT_TRUE(Watch(frames).empty());  // a count that no one counts
}

TEST(LogWatch, FindsDuplicates) {
  std::vector<LogFrame> frames = Healthy();
  auto f = At(frames, 0x18F, 1010);
  LogFrame again = *f;
  again.stamp_ns += 100'000;
  frames.insert(f + 1, again);
  ExpectOne(Watch(frames), Kind::kDuplicate, 0x18F, 0.0001);
}

TEST(LogWatch, FindsEmergenciesAndErrorMessagesAndTimesThatGoBack) {
  std::vector<LogFrame> frames = Healthy();
  const auto f = At(frames, 0x080, 1000);
  LogFrame emergency = DataFrame(0x081, {0x30, 0x81, 0x11, 0, 0, 0, 0, 0}, f->stamp_ns + 1);
  LogFrame over = DataFrame(0x081, {0, 0, 0, 0, 0, 0, 0, 0}, f->stamp_ns + 2);
  LogFrame bus_off = DataFrame(0x40, {0, 0, 0, 0, 0, 0, 0, 0}, f->stamp_ns + 3);
  bus_off.error = true;
  frames.insert(f + 1, {emergency, over, bus_off});
  const std::vector<Finding> found = Watch(frames);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].kind, Kind::kEmergency);
  EXPECT_EQ(found[0].code, 0x8130U);
  EXPECT_EQ(found[1].kind, Kind::kErrorMessage);
  frames = Healthy();
  At(frames, 0x080, 1000)->stamp_ns -= 5 * kMs;
  const std::vector<Finding> back = Watch(frames);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].kind, Kind::kTimeBack);
}

TEST(LogWatch, FindsSdosUnansweredLateOrAborted) {
  // The request a tenth of a second later shows it, or the end of the log.
  const std::vector<Finding> found = Watch(Without(0x581, 1000, 1010));
  ExpectOne(found, Kind::kSdoUnanswered, 0x601, 0.1);
  EXPECT_EQ(found[0].object, (can::Object{0x6041, 0}));
  std::vector<LogFrame> last = Without(0x601, 500, 2000);
  std::erase_if(last, [&](const LogFrame& f) {
    return f.id == 0x581 && f.stamp_ns > last.front().stamp_ns + 400 * kMs;
  });
  ExpectOne(Watch(last), Kind::kSdoUnanswered, 0x601, 1.590);
  std::vector<LogFrame> aborted = Healthy();
  const auto f = At(aborted, 0x581, 1000);
  std::copy_n(DataFrame(0, {0x80, 0x41, 0x60, 0, 2, 0, 1, 6}).data.begin(), 8, f->data.begin());
  const std::vector<Finding> abort = Watch(aborted);
  ExpectOne(abort, Kind::kSdoAborted, 0x581, 0.000295);
  EXPECT_EQ(abort[0].code, static_cast<std::uint32_t>(can::SdoAbort::kReadOnly));
  EXPECT_EQ(Watch(Healthy(), {.sdo_timeout_ns = 100'000}).size(), 20U);
}

TEST(LogWatch, NotesAnSdoToANodeThatIsNotHeardOfYet) {
  // The host is up first: what node 1 says before 250 ms is not there.
  std::vector<LogFrame> frames = Healthy();
  const std::int64_t begin = frames.front().stamp_ns;
  std::erase_if(frames, [begin](const LogFrame& f) {
    return (f.id == 0x581 || f.id == 0x701) && f.stamp_ns < begin + 250 * kMs;
  });
  const std::vector<Finding> found = Watch(frames);
  ASSERT_EQ(found.size(), 3U);  // asked at 0, 100 and 200 ms
  for (const Finding& finding : found) {
    EXPECT_EQ(finding.kind, Kind::kSdoBeforeBoot);
    EXPECT_TRUE(IsNote(finding.kind));
    EXPECT_EQ(finding.object, (can::Object{0x6041, 0}));
    EXPECT_NEAR(finding.seconds, 0.1, 1e-6);
  }
  // Its heartbeat alone is enough to be heard of: from then on it must answer.
  std::vector<LogFrame> silent = Healthy();
  std::erase_if(silent, [begin](const LogFrame& f) {
    return f.id == 0x581 && f.stamp_ns < begin + 250 * kMs;
  });
  EXPECT_EQ(Watch(silent).size(), 3U);
  EXPECT_EQ(Watch(silent)[0].kind, Kind::kSdoUnanswered);
}

TEST(LogWatch, FindsANodeThatIsNeverHeardOfHoweverOftenItIsAsked) {
  std::vector<LogFrame> frames = Healthy();
  std::erase_if(frames, [](const LogFrame& f) { return f.id == 0x581 || f.id == 0x701; });
  std::vector<Finding> found = Watch(frames);
  ASSERT_EQ(found.size(), 20U);  // 20 requests: 19 asked again, and the log's end
  ExpectOne({found.back()}, Kind::kSdoUnanswered, 0x601, 1.990);
  EXPECT_EQ(found.back().code, 1U);
  found.pop_back();
  EXPECT_TRUE(std::all_of(found.begin(), found.end(),
                          [](const Finding& f) { return f.kind == Kind::kSdoBeforeBoot; }));
}

TEST(LogWatch, FindsNoSilenceWhereThereAreNoTimes) {
  std::vector<LogFrame> frames = Without(0x080, 1000, 1100);
  for (LogFrame& frame : frames) {
    frame.stamped = false;
    frame.stamp_ns = 0;
  }
  EXPECT_TRUE(Watch(frames).empty());
}

TEST(LogWatch, EndsWhateverTheFramesAre) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::vector<LogFrame> frames = RandomFrames(3000, seed);
    Rng rng(seed);
    for (LogFrame& frame : frames) {
      frame.id = static_cast<std::uint32_t>(rng.Index(0x800));
      frame.channel = static_cast<std::uint8_t>(rng.Index(256));
      frame.stamp_ns = static_cast<std::int64_t>(rng.Next() >> 2);
      frame.stamped = rng.Index(3) > 0;
      frame.error = rng.Index(20) == 0;
      frame.remote = rng.Index(20) == 0;
    }
    Watch(frames);
  }
}

}  // namespace
}  // namespace pipewright::hil
