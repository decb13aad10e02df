// SPDX-License-Identifier: MIT
// Whatever byte is wrong or missing: no crash, an end, and every whole record before the damage.
#include <algorithm>

#include "tests/hil/canlog/read_log.h"

namespace pipewright::hil {
namespace {

using namespace test;

/// How many of the records of `text` end at or before byte `at`: text formats end them by a line
/// feed, and every line of these logs that is longer than `least` is a frame's.
std::size_t WholeLines(const std::string& text, std::size_t at) {
  const std::string begin = text.substr(0, at);
  std::size_t frames = 0;
  for (std::size_t feed = begin.find('\n'), from = 0; feed != std::string::npos;
       from = feed + 1, feed = begin.find('\n', from)) {
    const std::string line = begin.substr(from, feed - from);
    frames += line.find(" can0 ") != std::string::npos || line.find(" 1  ") != std::string::npos ||
                      line.find("CANFD") != std::string::npos
                  ? 1
                  : 0;
  }
  return frames;
}

/// The same of binary formats, by the sizes that the writer gave each frame.
std::size_t WholePackets(const std::vector<LogFrame>& frames, std::size_t head,
                         std::size_t beside_packet, std::size_t at) {
  std::size_t whole = 0;
  std::size_t end = head;
  for (const LogFrame& frame : frames) {
    end += beside_packet + (frame.fd ? 72U : 16U);
    whole += end <= at ? 1 : 0;
  }
  return whole;
}

std::size_t Whole(const NamedLog& log, const std::vector<LogFrame>& frames, std::size_t at) {
  if (log.name.starts_with("pcapng")) {
    const std::size_t head = log.bytes.size() - WholePackets(frames, 0, 0, 0);
    std::size_t packets = 0;
    for (const LogFrame& frame : frames) {
      packets += 32 + 12 + (frame.fd ? 72U : 16U);
    }
    return WholePackets(frames, head - packets, 32 + 12, at);
  }
  return log.name.starts_with("pcap") ? WholePackets(frames, 24, 16, at)
                                      : WholeLines(log.bytes, at);
}

TEST(DamagedLog, CutAtAnyByteGivesAllWholePacketsAndSaysThatItIsCut) {
  const std::vector<LogFrame> frames = OneOfEach();
  for (const NamedLog& log : InEveryFormat(frames)) {
    for (std::size_t at = 1; at < log.bytes.size() && log.name.starts_with("pcap"); ++at) {
      SCOPED_TRACE(log.name + ", byte " + std::to_string(at));
      const ReadLog read = Read(log.bytes.substr(0, at));
      ASSERT_EQ(read.open_error, "");
      ExpectFrames(read.frames, frames, Whole(log, frames, at));
      EXPECT_EQ(read.problems.malformed(), 0U);
      const bool whole_packet = Whole(log, frames, at) > Whole(log, frames, at - 1);
      const bool whole_head = Whole(log, frames, at) == 0;
      EXPECT_TRUE(whole_head || read.problems.end().empty() == whole_packet) << read.problems.end();
    }
  }
}

TEST(DamagedLog, CutAtAnyByteGivesAllWholeLinesAndSaysThatItIsCutOrTakesWhatIsLeft) {
  const std::vector<LogFrame> frames = OneOfEach();
  for (const NamedLog& log : InEveryFormat(frames)) {
    for (std::size_t at = 1; at < log.bytes.size() && !log.name.starts_with("pcap"); ++at) {
      SCOPED_TRACE(log.name + ", byte " + std::to_string(at));
      const ReadLog read = Read(log.bytes.substr(0, at));
      ASSERT_EQ(read.open_error, "");
      EXPECT_EQ(read.problems.malformed(), 0U);
      const std::size_t whole = Whole(log, frames, at);
      if (Whole(log, frames, at + 1) > whole) {  // only the line feed is missing
        ExpectFrames(read.frames, frames, whole + 1);
        EXPECT_EQ(read.problems.end(), "");
      } else if (read.frames.size() == whole) {
        ExpectFrames(read.frames, frames, whole);
      } else {  // what is left of the line is a line, too: a shorter payload
        ASSERT_EQ(read.frames.size(), whole + 1);
        EXPECT_EQ(read.frames[whole].id, frames[whole].id);
        EXPECT_EQ(read.frames[whole].stamp_ns, frames[whole].stamp_ns);
        EXPECT_LE(read.frames[whole].length, frames[whole].length);
        EXPECT_EQ(read.problems.end(), "");
      }
      if (log.bytes[at - 1] != '\n' && read.frames.size() == whole &&
          Whole(log, frames, log.bytes.find('\n', at) + 1) > whole) {
        EXPECT_NE(read.problems.end(), "") << "a frame was lost";
      }
    }
  }
}

TEST(DamagedLog, WithoutItsLastLineFeedIsWhole) {
  for (const char* text :
       {"(1.000000) can0 123#11", "(1.000000) can0 123#11\r", "  can0  123   [1]  11",
        "(1.000000) can0 7FF#\n(1.000000) can0 123#11",
        "date Mon Jan 1 00:00:00.000 am 2024\nbase hex  timestamps absolute\n"
        "   1.000000 1  123             Rx   d 1 11\nEnd TriggerBlock",
        "base hex  timestamps absolute\n   1.000000 1  123             Rx   d 1 11"}) {
    SCOPED_TRACE(text);
    const ReadLog read = Read(text);
    ASSERT_EQ(read.open_error, "");
    ASSERT_FALSE(read.frames.empty());
    EXPECT_EQ(read.frames.back().id, 0x123U);
    EXPECT_EQ(int{read.frames.back().data[0]}, 0x11);
    EXPECT_TRUE(read.problems.none()) << read.problems.end();
  }
}

TEST(DamagedLog, CutWhilePackedIsNotWholeThoughItsLastLineMakesSense) {
  const std::string packed = Gz("(1.000000) can0 123#11\n(2.000000) can0 123#1122");
  for (std::size_t less = 1; less < 30; ++less) {
    const ReadLog read = Read(packed.substr(0, packed.size() - less));
    EXPECT_NE(read.problems.end(), "") << less;
    EXPECT_LE(read.frames.size(), 1U) << less;
  }
}

TEST(DamagedLog, CutWhilePackedGivesABeginningAndSaysSo) {
  const std::vector<LogFrame> frames = RandomFrames(6000, 2);
  const std::string text = CandumpLog(frames);
  for (const std::string& packed : {Gz(text), Zstd(text)}) {
    std::size_t most = 0;
    for (std::size_t at = 1; at < packed.size(); at += 997) {
      SCOPED_TRACE(at);
      const ReadLog read = Read(packed.substr(0, at));
      ASSERT_EQ(read.open_error, "");
      ASSERT_LE(read.frames.size(), frames.size());
      ExpectFrames(read.frames, frames, read.frames.size());
      EXPECT_NE(read.problems.end(), "");
      most = std::max(most, read.frames.size());
    }
    EXPECT_GT(most, 0U);
  }
}

TEST(DamagedLog, WithAnyByteFlippedStillEnds) {
  const std::vector<LogFrame> frames = OneOfEach();
  Rng rng(6);
  for (const NamedLog& log : InEveryFormat(frames)) {
    for (std::size_t at = 0; at < log.bytes.size(); ++at) {
      SCOPED_TRACE(log.name + ", byte " + std::to_string(at));
      std::string bytes = log.bytes;
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << rng.Index(8)));
      const ReadLog read = Read(bytes);
      // A line feed flipped in or out makes one record more, or two of one.
      EXPECT_LE(read.frames.size(), frames.size() + 1);
    }
  }
}

TEST(DamagedLog, PackedWithAnyByteFlippedStillEnds) {
  const std::vector<LogFrame> frames = RandomFrames(100, 3);
  const std::string text = CandumpLog(frames);
  Rng rng(7);
  for (const std::string& packed : {Gz(text), Zstd(text)}) {
    for (std::size_t at = 0; at < packed.size(); ++at) {
      std::string bytes = packed;
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << rng.Index(8)));
      const ReadLog read = Read(bytes);
      EXPECT_LE(read.frames.size(), 1000U);
    }
  }
}

TEST(DamagedLog, OfAnyBytesStillEnds) {
  Rng rng(8);
  const std::vector<NamedLog> logs = InEveryFormat(OneOfEach());
  for (int k = 0; k < 2000; ++k) {
    // A true beginning, so that a reader is chosen, then pieces of logs and noise.
    std::string bytes = logs[static_cast<std::size_t>(rng.Index(14))].bytes.substr(0, 60);
    for (int piece = 0; piece < 8; ++piece) {
      const std::string& log = logs[static_cast<std::size_t>(rng.Index(14))].bytes;
      const auto from = static_cast<std::size_t>(rng.Index(static_cast<int>(log.size())));
      bytes += log.substr(from, static_cast<std::size_t>(rng.Index(90)));
      for (int i = rng.Index(6); i > 0; --i) {
        bytes += static_cast<char>(rng.Index(256));
      }
    }
    EXPECT_LE(Read(bytes).frames.size(), bytes.size());
  }
}

}  // namespace
}  // namespace pipewright::hil
