// SPDX-License-Identifier: MIT
#include "hil/canlog/log_diff.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

using namespace test;

/// Feeds both in blocks of odd sizes, as Behind() asks.
void Feed(LogDiff& diff, const std::vector<LogFrame>& first, const std::vector<LogFrame>& second) {
  const std::array<const std::vector<LogFrame>*, 2> logs = {&first, &second};
  std::array<std::size_t, 2> at{};
  for (int open = 2; open > 0;) {
    const auto which = static_cast<std::size_t>(diff.Behind());
    const std::size_t block = std::min<std::size_t>(7 + 6 * which, logs[which]->size() - at[which]);
    diff.Add(static_cast<int>(which), std::span(*logs[which]).subspan(at[which], block));
    at[which] += block;
    if (block == 0) {
      diff.End(static_cast<int>(which));
      --open;
    }
  }
}

std::map<IdKey, std::vector<LogFrame>> ById(const std::vector<LogFrame>& frames) {
  std::map<IdKey, std::vector<LogFrame>> ids;
  for (const LogFrame& frame : frames) {
    ids[KeyOf(frame)].push_back(frame);
  }
  return ids;
}

void ExpectAsBruteForce(const std::vector<LogFrame>& first, const std::vector<LogFrame>& second) {
  LogDiff diff;
  Feed(diff, first, second);
  std::map<IdKey, std::vector<LogFrame>> a = ById(first);
  std::map<IdKey, std::vector<LogFrame>> b = ById(second);
  for (const LogDiff::Entry* const entry : diff.Sorted()) {
    const std::vector<LogFrame>& its_a = a[entry->key];
    const std::vector<LogFrame>& its_b = b[entry->key];
    const IdDiff& id = entry->value;
    std::size_t same = 0;
    while (same < std::min(its_a.size(), its_b.size()) && SameOnTheWire(its_a[same], its_b[same])) {
      ++same;
    }
    EXPECT_EQ(id.frames[0], its_a.size());
    EXPECT_EQ(id.frames[1], its_b.size());
    EXPECT_EQ(id.same, same);
    EXPECT_FALSE(id.given_up);
    const bool parts = same < std::max(its_a.size(), its_b.size());
    ASSERT_EQ(id.first.has_value(), parts);
    EXPECT_EQ(id.differs(), parts);
    if (parts) {
      EXPECT_EQ(id.first->index, same);
      EXPECT_EQ(id.first->frames[0].has_value(), same < its_a.size());
      EXPECT_EQ(id.first->frames[1].has_value(), same < its_b.size());
    }
  }
  EXPECT_EQ(diff.Sorted().size(), a.size());  // made whole by the look-ups above
  EXPECT_EQ(diff.Sorted().size(), b.size());
}

TEST(LogDiff, FindsWhereBruteForceFindsIt) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<LogFrame> first = RandomFrames(800, seed);
    std::vector<LogFrame> second = first;
    Rng rng(seed);
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(rng.Index(static_cast<int>(second.size())));
      switch (rng.Index(4)) {
        case 0:
          second[at].data[0] = static_cast<std::uint8_t>(second[at].data[0] ^ 1);
          break;
        case 1:
          second.erase(second.begin() + static_cast<std::ptrdiff_t>(at));
          break;
        case 2:
          second.insert(second.begin() + static_cast<std::ptrdiff_t>(at), second[at]);
          break;
        default:
          second.resize(std::max<std::size_t>(at, 1));
      }
    }
    ExpectAsBruteForce(first, second);
    ExpectAsBruteForce(second, first);
    ExpectAsBruteForce(first, first);
  }
  ExpectAsBruteForce(RandomFrames(100, 1), {});
}

TEST(LogDiff, DoesNotMindTheOrderBetweenIdsNorWhenTheLogsBegin) {
  const std::vector<LogFrame> first = RandomFrames(500, 3);
  std::vector<LogFrame> second = first;
  for (LogFrame& frame : second) {
    frame.stamp_ns += 3'000'000'000'000;
    frame.channel = 1;
  }
  for (std::size_t i = 0; i + 1 < second.size(); i += 2) {
    if (!(KeyOf(second[i]) == KeyOf(second[i + 1]))) {
      std::swap(second[i], second[i + 1]);
    }
  }
  LogDiff diff;
  Feed(diff, first, second);
  for (const LogDiff::Entry* const entry : diff.Sorted()) {
    EXPECT_FALSE(entry->value.differs());
  }
}

TEST(LogDiff, TellsByHowMuchTheSecondIsLater) {
  std::vector<LogFrame> first;
  std::vector<LogFrame> second;
  for (int i = 0; i < 11; ++i) {
    first.push_back(DataFrame(0x100, {i}, 1'000'000'000LL * i));
    second.push_back(DataFrame(0x100, {i}, 500 + 1'000'000'000LL * i + 1'000'000LL * i));
  }
  LogDiff diff;
  Feed(diff, first, second);
  const PeriodStats& later = diff.Sorted().front()->value.later;
  EXPECT_EQ(later.count(), 11U);
  EXPECT_DOUBLE_EQ(later.min_s(), 0);
  EXPECT_DOUBLE_EQ(later.max_s(), 0.010);
  EXPECT_NEAR(later.mean_s(), 0.005, 1e-12);
}

TEST(LogDiff, GivesUpAnIdThatIsTooFarAhead) {
  // No times: both are read frame by frame, and the one's id 1 comes after all of its id 2.
  LogDiff diff;
  std::vector<LogFrame> one(LogDiff::kMostPending + 10, DataFrame(1, {}));
  for (LogFrame& frame : one) {
    frame.stamped = false;
  }
  std::vector<LogFrame> two = one;
  two.resize(100);
  for (LogFrame& frame : two) {
    frame.id = 2;
  }
  diff.Add(0, one);
  diff.Add(1, two);
  diff.Add(0, two);
  diff.End(0);
  diff.Add(1, one);
  diff.End(1);
  EXPECT_TRUE(diff.Sorted()[0]->value.given_up);
  EXPECT_FALSE(diff.Sorted()[1]->value.given_up);
  EXPECT_EQ(diff.Sorted()[1]->value.same, two.size());
  EXPECT_EQ(diff.Sorted()[0]->value.frames, (std::array<std::uint64_t, 2>{one.size(), one.size()}));
}

}  // namespace
}  // namespace pipewright::hil
