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

TEST(DamagedLog, CutAtAnyByteGivesAllWholeRecordsAndSaysThatItIsCut) {
  const std::vector<LogFrame> frames = OneOfEach();
  for (const NamedLog& log : InEveryFormat(frames)) {
    for (std::size_t at = 1; at < log.bytes.size(); ++at) {
      SCOPED_TRACE(log.name + ", byte " + std::to_string(at));
      const ReadLog read = Read(log.bytes.substr(0, at));
      ASSERT_EQ(read.open_error, "");
      ExpectFrames(read.frames, frames, Whole(log, frames, at));
      EXPECT_EQ(read.problems.malformed(), 0U);
      const bool between = read.problems.end().empty();
      const bool whole_line = log.bytes[at - 1] == '\n' && !log.name.starts_with("pcap");
      const bool whole_packet =
          log.name.starts_with("pcap") && Whole(log, frames, at) > Whole(log, frames, at - 1);
      const bool whole_head = log.name.starts_with("pcap") && Whole(log, frames, at) == 0;
      EXPECT_TRUE(whole_head || between == (whole_line || whole_packet)) << read.problems.end();
    }
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
