// SPDX-License-Identifier: MIT
#include "tests/timing/replay/replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "tests/timing/replay/recorder.h"
#include "tests/timing/replay/stack_mark.h"
#include "tests/timing/replay/temporary_file.h"

namespace pipewright::timing {
namespace {

constexpr int kSkipped = 20;
constexpr int kCycles = 130;

std::string RecordLoop(double rate_hz, std::uint64_t seed = 1) {
  bench::ControlLoop loop(rate_hz, seed, nullptr);
  TemporaryFile file;
  const char* problem = Record(loop, seed, kSkipped, kCycles, file.get());
  EXPECT_EQ(problem, nullptr) << (problem == nullptr ? "" : problem);
  return file.Contents();
}

ReplayResult ReplayOf(const std::string& recording, std::string* sent = nullptr) {
  const TemporaryFile file(recording);
  TemporaryFile sent_file;
  RecordingReader reader(file.get());
  const auto replay = std::make_unique<Replay>();
  ReplayResult result;
  EXPECT_TRUE(replay->Run(reader, sent_file.get(), result)) << reader.problem();
  if (sent != nullptr) {
    *sent = sent_file.Contents();
  }
  return result;
}

/// The same recording with one cycle changed, and a right hash again.
template <typename Change>
std::string With(const std::string& recording, int at, const Change& change) {
  const TemporaryFile in(recording);
  TemporaryFile out;
  RecordingReader reader(in.get());
  RecordingHead head;
  EXPECT_TRUE(reader.ReadHead(head));
  RecordingWriter writer(out.get(), head);
  const auto cycle = std::make_unique<RecordedCycle>();
  for (int i = 0; reader.Next(*cycle); ++i) {
    if (i == at) {
      change(*cycle);
    }
    writer.Add(*cycle);
  }
  EXPECT_TRUE(writer.Finish());
  return out.Contents();
}

class ReplayAt : public testing::TestWithParam<double> {};

TEST_P(ReplayAt, SendsWhatWasSent) {
  const std::string recording = RecordLoop(GetParam());
  std::string sent;
  const ReplayResult result = ReplayOf(recording, &sent);
  EXPECT_EQ(result.counted, kCycles);
  EXPECT_GT(result.cycles, kSkipped + kCycles);
  EXPECT_GT(result.frames, kCycles);
  EXPECT_EQ(result.different, 0);
  EXPECT_EQ(result.incomparable, 0);
  EXPECT_EQ(result.first_different, -1);
  EXPECT_TRUE(result.Within(0));
  EXPECT_EQ(std::count(sent.begin(), sent.end(), '\n'), result.frames);
  EXPECT_NE(sent.find(" can0 111#"), std::string::npos);
  EXPECT_NE(sent.find(" can1 207#"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Rates, ReplayAt, testing::Values(100, 1000));

TEST(Recorder, WritesTheSameFileTwice) { EXPECT_EQ(RecordLoop(100), RecordLoop(100)); }

TEST(Recorder, WritesAnotherFileForAnotherSeed) {
  // Not in the head alone: the goals are others, and so are the frames.
  const std::string one = RecordLoop(100, 1);
  const std::string other = RecordLoop(100, 2);
  EXPECT_NE(one.substr(one.size() / 2), other.substr(other.size() / 2));
}

class ReplaySees : public testing::Test {
 protected:
  static void SetUpTestSuite() { recording_ = RecordLoop(100); }
  static std::string recording_;
};
std::string ReplaySees::recording_;

/// A cycle amid the counted ones, at which the arm is commanded.
constexpr int kAt = 150;

TEST_F(ReplaySees, OneLsbOfOneJoint) {
  const ReplayResult result = ReplayOf(With(recording_, kAt, [](RecordedCycle& cycle) {
    for (can::Frame& frame : cycle.arm_out) {
      if (frame.id == 0x204) {
        frame.data[2] ^= 1;  // the lowest bit of the velocity
      }
    }
  }));
  EXPECT_EQ(result.different, 1);
  EXPECT_EQ(result.incomparable, 0);
  EXPECT_EQ(result.largest_lsb, 1);
  EXPECT_EQ(result.first_different, kAt);
  EXPECT_FALSE(result.Within(0));
  EXPECT_TRUE(result.Within(1));
}

TEST_F(ReplaySees, AFrameThatWasNotSent) {
  const ReplayResult result =
      ReplayOf(With(recording_, kAt, [](RecordedCycle& cycle) { cycle.arm_out.pop_back(); }));
  EXPECT_EQ(result.different, 1);
  EXPECT_EQ(result.incomparable, 1);
  EXPECT_FALSE(result.Within(1000));
}

TEST_F(ReplaySees, AnotherReading) {
  // A joint a milliradian off in one cycle: the law answers with another velocity.
  const ReplayResult result = ReplayOf(With(recording_, kAt, [](RecordedCycle& cycle) {
    for (can::Frame& frame : cycle.arm_in) {
      if (frame.id == 0x182) {
        frame.data[1] = static_cast<std::uint8_t>(frame.data[1] + 4);  // 4 * 256 urad
      }
    }
  }));
  EXPECT_GT(result.different, 0);
  EXPECT_GT(result.largest_lsb, 1);
  EXPECT_EQ(result.first_different, kAt);
}

[[gnu::noinline]] void TakeStack() {
  volatile char bytes[20000];
  for (volatile char& byte : bytes) {
    byte = 1;
  }
}

TEST(StackMark, SeesWhatACallTook) {
  PaintStack();
  const int before = StackUsed();
  PaintStack();
  TakeStack();
  const int after = StackUsed();
  EXPECT_LT(before, 1000);
  EXPECT_GE(after, 20000);
  EXPECT_LT(after, 22000);
}

}  // namespace
}  // namespace pipewright::timing
