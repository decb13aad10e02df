// SPDX-License-Identifier: MIT
#include "hil/replay/recorded_bus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/can_logs.h"
#include "tests/support/command.h"

namespace pipewright::hil {
namespace {

using std::chrono_literals::operator""ms;

constexpr std::int64_t kMs = 1'000'000;

/// States of base and arm and commands to them, one each 0.7 ms from `begin_ns`.
std::vector<LogFrame> Log(int frames, std::int64_t begin_ns = 0) {
  constexpr std::uint32_t kIds[] = {0x211, 0x111, 0x181, 0x201, 0x221, 0x77F, 0x587};
  std::vector<LogFrame> log;
  for (int i = 0; i < frames; ++i) {
    log.push_back(test::DataFrame(kIds[i % 7], {i & 0xFF, 1, 2, 3}, begin_ns + 700'000LL * i));
  }
  return log;
}

std::string File(const std::string& bytes) {
  static const std::filesystem::path folder = test::TestFolder();
  test::WriteFile(folder / "can.log", bytes);
  return folder / "can.log";
}

struct Heard {
  can::Frame frame;
  Time at{};
};

struct Replayed {
  std::string error;
  std::vector<Heard> heard;
  Time end{};
};

/// Steps of 1 ms until the log's end.
Replayed Play(RecordedBus& bus) {
  Replayed run;
  run.error = bus.Open();
  for (bus.AdvanceTo(run.end); run.error.empty() && !bus.AtEnd(); bus.AdvanceTo(run.end += 1ms)) {
    can::Frame frame;
    while (bus.Receive(frame)) {
      run.heard.push_back({frame, run.end});
    }
  }
  can::Frame frame;
  while (bus.Receive(frame)) {
    run.heard.push_back({frame, run.end});
  }
  bus.ReadToEnd();
  return run;
}

std::vector<LogFrame> States(const std::vector<LogFrame>& log, std::size_t count) {
  std::vector<LogFrame> states(log.begin(), log.begin() + static_cast<std::ptrdiff_t>(count));
  std::erase_if(states, IsCommand);
  return states;
}

void ExpectHeard(const std::vector<Heard>& heard, const std::vector<LogFrame>& states) {
  ASSERT_EQ(heard.size(), states.size());
  for (std::size_t i = 0; i < heard.size(); ++i) {
    EXPECT_EQ(heard[i].frame, ClassicFrame(states[i])) << i;
    EXPECT_EQ(heard[i].frame.stamp, Time(Duration(states[i].stamp_ns))) << i;
  }
}

TEST(RecordedBus, GivesEachStateAtTheFirstStepFromItsStampOn) {
  const std::vector<LogFrame> log = Log(100);
  for (const test::NamedLog& form : test::InEveryFormat(log)) {
    SCOPED_TRACE(form.name);
    RecordedBus bus(File(form.bytes));
    const Replayed run = Play(bus);
    ASSERT_EQ(run.error, "");
    EXPECT_EQ(bus.passed_over(), 0U);
    ExpectHeard(run.heard, States(log, log.size()));
    for (const Heard& one : run.heard) {
      EXPECT_GE(one.at, one.frame.stamp);
      EXPECT_LT(one.at - one.frame.stamp, 1ms);
    }
    EXPECT_EQ(bus.states() + bus.commands(), log.size());
  }
}

TEST(RecordedBus, AStampOnAStepIsOfThatStep) {
  std::vector<LogFrame> log = {test::DataFrame(0x211, {1}, 5 * kMs),
                               test::DataFrame(0x211, {2}, 5 * kMs + 1000),
                               test::DataFrame(0x211, {3}, 6 * kMs)};
  RecordedBus bus(File(test::CandumpLog(log)));
  const Replayed run = Play(bus);
  ASSERT_EQ(run.heard.size(), 3U);
  EXPECT_EQ(run.heard[0].at, Time{5ms});
  EXPECT_EQ(run.heard[1].at, Time{6ms});
  EXPECT_EQ(run.end, Time{6ms});  // at the last stamp the log does not tell any more what follows
}

TEST(RecordedBus, PutsTwoChannelsIntoTheOrderOfTime) {
  const std::vector<LogFrame> log = Log(200);
  std::vector<LogFrame> shuffled = log;  // each 8 frames: first one channel's, then the other's
  for (auto at = shuffled.begin(); at != shuffled.end(); at += 8) {
    std::stable_partition(at, at + 8, [](const LogFrame& f) { return f.id < 0x200; });
  }
  RecordedBus bus(File(test::CandumpLog(shuffled)));
  ExpectHeard(Play(bus).heard, States(log, log.size()));
}

TEST(RecordedBus, CountsCalendarStampsFromItsFirstFrame) {
  const std::vector<LogFrame> log = Log(50);
  RecordedBus bus(File(test::CandumpLog(Log(50, 1'699'000'000'123'456'000))));
  ExpectHeard(Play(bus).heard, States(log, log.size()));
}

TEST(RecordedBus, ComparesWhatIsSentWithWhatWas) {
  std::vector<LogFrame> log;
  for (int k = 0; k < 20; ++k) {
    log.push_back(test::DataFrame(0x111, {k, 0, 0, 0, 0, 0, 0, 0}, 10 * kMs * k + 300'000));
    log.push_back(test::DataFrame(0x221, {0}, 10 * kMs * k + 400'000));
  }
  log[20].data[3] = 7;
  RecordedBus bus(File(test::CandumpLog(log)));
  ASSERT_EQ(bus.Open(), "");
  Time now{};
  for (bus.AdvanceTo(now); !bus.AtEnd(); bus.AdvanceTo(now += 1ms)) {
    const auto ms = static_cast<int>(now.time_since_epoch() / 1ms);
    if (ms % 10 == 0) {
      const can::Frame sent = ClassicFrame(test::DataFrame(0x111, {ms / 10, 0, 0, 0, 0, 0, 0, 0}));
      EXPECT_EQ(bus.Send(sent), Status::kOk);
    }
  }
  bus.comparison().End(now);
  EXPECT_EQ(bus.comparison().same(), 19U);
  EXPECT_EQ(bus.comparison().differences(), 1U);
  EXPECT_EQ(bus.comparison().first()->at(), Time{100ms + std::chrono::microseconds(300)});
}

TEST(RecordedBus, CutAtAnyByteGivesAllThatIsWhole) {
  const std::vector<LogFrame> log = Log(24);
  const std::string text = test::CandumpLog(log);
  for (std::size_t at = 1; at < text.size(); ++at) {
    SCOPED_TRACE(at);
    const std::string begin = text.substr(0, at);
    const auto whole = static_cast<std::size_t>(std::count(begin.begin(), begin.end(), '\n'));
    RecordedBus bus(File(begin));
    const Replayed run = Play(bus);
    ASSERT_EQ(run.error, "");
    ExpectHeard(run.heard, States(log, whole));
    EXPECT_EQ(bus.log().whole(), begin.back() == '\n');
  }
}

TEST(RecordedBus, WithAnyByteFlippedEndsSoonAndTellsWhatItPassedOver) {
  const std::vector<LogFrame> log = Log(24);
  const std::string text = test::CandumpLog(log);
  Rng rng(11);
  for (std::size_t at = 0; at < text.size(); ++at) {
    SCOPED_TRACE(at);
    std::string damaged = text;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << rng.Index(8)));
    RecordedBus bus(File(damaged));
    const Replayed run = Play(bus);
    EXPECT_LE(run.end, Time{RecordedBus::kLongestSilence + 100ms});
    const std::uint64_t passed_over = bus.passed_over() + bus.beyond_silence();
    // A line feed flipped in or out makes one record more, or two of one.
    EXPECT_LE(bus.states() + bus.commands() + passed_over, log.size() + 1);
    EXPECT_TRUE(!bus.log().whole() || !run.error.empty() ||
                bus.states() + bus.commands() + passed_over == log.size());
  }
}

TEST(RecordedBus, RefusesWhatIsNoLogAndALogWithoutTimes) {
  RecordedBus none("/no/such/can.log");
  EXPECT_NE(none.Open().find("/no/such/can.log: no such file"), std::string::npos);
  RecordedBus noise(File("years of work\nand more\n"));
  EXPECT_NE(noise.Open().find("can.log: is no log"), std::string::npos);
  RecordedBus untimed(File("  can0  123   [2]  DE AD\n  can0  124   [2]  DE AD\n"));
  EXPECT_NE(untimed.Open().find("has a time"), std::string::npos) << untimed.Open();
}

}  // namespace
}  // namespace pipewright::hil
