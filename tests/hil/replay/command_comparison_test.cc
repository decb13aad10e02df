// SPDX-License-Identifier: MIT
#include "hil/replay/command_comparison.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""ms;

constexpr std::uint32_t kTwist = 0x111;  // to the base
constexpr std::uint32_t kJoint = 0x203;  // to the arm

/// A robot that sends two commands a cycle, and a log of them. Cycle k sends at 10 k ms, and has
/// the base's on the wire 0.3 ms later, the arm's 0.7 ms later.
class Recording {
 public:
  struct Command {
    int cycle;
    LogFrame logged;
  };

  explicit Recording(int cycles) : cycles_(cycles) {
    for (int k = 0; k < cycles; ++k) {
      log_.push_back({k, test::DataFrame(kTwist, Payload(k, 8), 10'000'000LL * k + 300'000)});
      log_.push_back({k, test::DataFrame(kJoint, Payload(k, 6), 10'000'000LL * k + 700'000)});
    }
  }

  std::vector<Command>& log() { return log_; }

  /// Compares the log with a replay that sends what the robot sent, but for `replace`.
  CommandComparison Compare(int replayed_cycles) const {
    CommandComparison comparison;
    std::size_t next = 0;
    for (int k = 0; k < replayed_cycles; ++k) {
      const Time now{10ms * k};
      for (; next < log_.size() && log_[next].logged.stamp_ns <= now.time_since_epoch().count();
           ++next) {
        comparison.Recorded(log_[next].logged);
      }
      comparison.Replayed(ClassicFrame(test::DataFrame(kTwist, Payload(k, 8))), now);
      comparison.Replayed(ClassicFrame(test::DataFrame(kJoint, Payload(k, 6))), now);
    }
    for (; next < log_.size(); ++next) {
      comparison.Recorded(log_[next].logged);
    }
    comparison.End(Time{10ms * replayed_cycles});
    return comparison;
  }
  CommandComparison Compare() const { return Compare(cycles_); }

  /// Of the first ten cycles all alike, as a robot that stands; then each its own.
  static std::vector<int> Payload(int cycle, int bytes) {
    std::vector<int> payload(static_cast<std::size_t>(bytes), 0);
    payload[0] = cycle < 10 ? 0 : cycle;
    return payload;
  }

 private:
  int cycles_;
  std::vector<Command> log_;
};

void ExpectCounts(const CommandCounts& counts, std::uint64_t same, std::uint64_t different,
                  std::uint64_t not_replayed, std::uint64_t not_recorded) {
  EXPECT_EQ(counts.same, same);
  EXPECT_EQ(counts.different, different);
  EXPECT_EQ(counts.not_replayed, not_replayed);
  EXPECT_EQ(counts.not_recorded, not_recorded);
}

TEST(IsCommand, IsWhatTheRobotSends) {
  for (const std::uint32_t id :
       {0x111, 0x121, 0x421, 0x441, 0x000, 0x080, 0x201, 0x207, 0x601, 0x607, 0x77F}) {
    EXPECT_TRUE(IsCommand(test::DataFrame(id, {}))) << std::hex << id;
  }
  for (const std::uint32_t id :
       {0x211, 0x221, 0x311, 0x361, 0x081, 0x181, 0x287, 0x581, 0x701, 0x707, 0x7E5, 0x123}) {
    EXPECT_FALSE(IsCommand(test::DataFrame(id, {}))) << std::hex << id;
  }
  LogFrame extended = test::DataFrame(0x111, {});
  extended.extended = true;
  EXPECT_FALSE(IsCommand(extended));
}

TEST(CommandComparison, OfARecordingWithItselfFindsNothing) {
  const CommandComparison comparison = Recording(30).Compare();
  ExpectCounts(comparison.total(), 60, 0, 0, 0);
  EXPECT_FALSE(comparison.first());
  ASSERT_EQ(comparison.Sorted().size(), 2U);
  EXPECT_EQ(comparison.Sorted()[0]->key.id, kTwist);
  ExpectCounts(comparison.Sorted()[1]->value, 30, 0, 0, 0);
}

TEST(CommandComparison, NamesAFrameThatIsOtherwise) {
  for (const int cycle : {0, 5, 17, 29}) {
    SCOPED_TRACE(cycle);
    Recording recording(30);
    LogFrame& altered = recording.log()[static_cast<std::size_t>(2 * cycle + 1)].logged;
    altered.data[5] ^= 1;
    const CommandComparison comparison = recording.Compare();
    ExpectCounts(comparison.total(), 59, 1, 0, 0);
    ASSERT_TRUE(comparison.first());
    EXPECT_EQ(comparison.first()->at(), Time{10ms * cycle + std::chrono::microseconds(700)});
    EXPECT_TRUE(SameOnTheWire(*comparison.first()->recorded, altered));
    EXPECT_EQ(comparison.first()->replayed->data[5], altered.data[5] ^ 1);
    EXPECT_EQ(comparison.first()->replayed->stamp_ns, 10'000'000LL * cycle);
    ExpectCounts(comparison.Sorted()[0]->value, 30, 0, 0, 0);
    ExpectCounts(comparison.Sorted()[1]->value, 29, 1, 0, 0);
  }
}

TEST(CommandComparison, CountsAFrameThatTheRecordingLacksOnceWhereverItIs) {
  for (std::size_t lost = 0; lost < 58; ++lost) {  // but for the last cycle's
    SCOPED_TRACE(lost);
    Recording recording(30);
    recording.log().erase(recording.log().begin() + static_cast<std::ptrdiff_t>(lost));
    const CommandComparison comparison = recording.Compare();
    ExpectCounts(comparison.total(), 59, 0, 0, 1);
    ASSERT_TRUE(comparison.first());
    EXPECT_FALSE(comparison.first()->recorded);
    EXPECT_EQ(comparison.first()->replayed->id, lost % 2 == 0 ? kTwist : kJoint);
  }
}

TEST(CommandComparison, CountsAFrameThatTheReplayLacks) {
  Recording recording(30);
  LogFrame more = recording.log()[40].logged;
  more.stamp_ns += 100'000;
  recording.log().insert(recording.log().begin() + 41, {20, more});
  const CommandComparison comparison = recording.Compare();
  ExpectCounts(comparison.total(), 60, 0, 1, 0);
  EXPECT_FALSE(comparison.first()->replayed);
  EXPECT_EQ(comparison.first()->recorded->stamp_ns, more.stamp_ns);
}

TEST(CommandComparison, AFrameCannotBeOnTheWireBeforeItIsSent) {
  Recording recording(30);
  recording.log()[40].logged.stamp_ns -= 5'000'000;
  std::swap(recording.log()[40], recording.log()[39]);
  const CommandComparison comparison = recording.Compare();
  EXPECT_GT(comparison.total().not_replayed, 0U);
}

TEST(CommandComparison, LeavesOutWhatStillWaitsForTheWireAtTheEnd) {
  ExpectCounts(Recording(30).Compare(31).total(), 60, 0, 0, 0);
  // A robot that the recording does not hear any more for longer than that is told.
  ExpectCounts(Recording(30).Compare(60).total(), 60, 0, 0, 40);
}

TEST(CommandComparison, FindsTheEarliestDifferenceOfAnyId) {
  Recording recording(30);
  recording.log()[2 * 20 + 1].logged.data[1] = 9;
  recording.log().erase(recording.log().begin() + 2 * 4);  // found only when the robot moves
  const CommandComparison comparison = recording.Compare();
  ExpectCounts(comparison.total(), 58, 1, 0, 1);
  EXPECT_EQ(comparison.first()->replayed->id, kTwist);
  EXPECT_LT(comparison.first()->at(), Time{110ms});
}

}  // namespace
}  // namespace pipewright::hil
