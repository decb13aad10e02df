// SPDX-License-Identifier: MIT
// One log, whatever it is written in.
#include "hil/canlog/log_reader.h"

#include "tests/hil/canlog/read_log.h"

namespace pipewright::hil {
namespace {

using namespace test;

TEST(LogReader, ReadsTheSameFramesFromEveryFormatPlainOrPacked) {
  const std::vector<LogFrame> frames = OneOfEach();
  for (const NamedLog& log : InEveryFormat(frames)) {
    for (const auto& [packing, bytes] :
         {NamedLog{"plain", log.bytes}, NamedLog{"gz", Gz(log.bytes)},
          NamedLog{"zstd", Zstd(log.bytes)}}) {
      SCOPED_TRACE(log.name + ", " + packing);
      const ReadLog read = Read(bytes);
      EXPECT_EQ(read.open_error, "");
      EXPECT_TRUE(read.problems.none()) << read.problems.end();
      ExpectFrames(read.frames, frames, frames.size());
    }
  }
}

TEST(LogReader, ReadsMoreThanOneWindowOfIt) {
  const std::vector<LogFrame> frames = RandomFrames(30000, 1);
  for (const NamedLog& log : InEveryFormat(frames)) {
    SCOPED_TRACE(log.name);
    ASSERT_GT(log.bytes.size(), 2 * ByteWindow::kBytes);
    const ReadLog read = Read(log.bytes);
    EXPECT_TRUE(read.problems.none()) << read.problems.end();
    ExpectFrames(read.frames, frames, frames.size());
  }
}

TEST(LogReader, NamesTheFormatThatItFound) {
  const std::vector<LogFrame> frames = OneOfEach();
  for (const NamedLog& log : InEveryFormat(frames)) {
    const ReadLog read = Read(log.bytes);
    EXPECT_TRUE(log.name.starts_with(read.format)) << log.name << ": " << read.format;
  }
  EXPECT_EQ(Read("").format, "empty");
}

TEST(LogReader, SaysWhyAFileIsNoLog) {
  ChannelNames channels;
  EXPECT_EQ(LogReader(channels).Open("none.log", {}), "none.log: no such file");
  EXPECT_EQ(LogReader(channels).Open("/", {}), "/: is a folder");
  EXPECT_NE(Read("a shopping list\nmilk\n").open_error.find("is no log that is known"),
            std::string::npos);
  EXPECT_NE(Read(std::string(50, '\0')).open_error.find("is no log that is known"),
            std::string::npos);
  EXPECT_NE(Read(std::string(5000, 'x')).open_error.find("is no log that is known"),
            std::string::npos);
}

TEST(LogReader, TakesAnEmptyFileForALogOfNothing) {
  const ReadLog read = Read("");
  EXPECT_EQ(read.open_error, "");
  EXPECT_TRUE(read.frames.empty());
  EXPECT_TRUE(read.problems.none());
}

TEST(LogReader, TellsOfMalformedLinesAndReadsOn) {
  const ReadLog read = Read(
      "# a comment\n"
      "(1.000000) can0 123#11\n"
      "(2.000000) can0 123#1\n"
      "\n"
      "(3.000000) can0 123#22\r\n"
      "what?\n" +
      std::string(5000, 'y') + "\n(4.000000) can1 123#33\n");
  ExpectFrames(read.frames,
               {DataFrame(0x123, {0x11}, 1'000'000'000), DataFrame(0x123, {0x22}, 3'000'000'000),
                DataFrame(0x123, {0x33}, 4'000'000'000)},
               3);
  EXPECT_EQ(read.channels, (std::vector<std::string>{"can0", "can1"}));
  EXPECT_EQ(int{read.frames[2].channel}, 1);
  EXPECT_EQ(read.problems.malformed(), 3U);
  ASSERT_EQ(read.problems.told().size(), 3U);
  EXPECT_EQ(read.problems.told()[0],
            "line 3: expected at most 8 bytes in pairs of hex digits: '(2.000000) can0 123#1'");
  EXPECT_EQ(read.problems.told()[1],
            "line 6: expected a time such as (1699000000.123456): 'what?'");
  EXPECT_EQ(read.problems.told()[2], "line 7: expected a line of less than 4096 bytes");
  EXPECT_EQ(read.problems.end(), "");
}

TEST(LogReader, CountsAllMalformedLinesAndTellsTheFirst) {
  std::string text = "(1.000000) can0 123#11\n";
  for (int i = 0; i < 1000; ++i) {
    text += "\x1b[31m(2) can0\n";
  }
  const ReadLog read = Read(text);
  EXPECT_EQ(read.problems.malformed(), 1000U);
  EXPECT_EQ(read.problems.told().size(), LogProblems::kTold);
  EXPECT_EQ(read.problems.told()[0].find('\x1b'), std::string::npos);  // safe on a terminal
}

TEST(LogReader, TellsADeltaLogFromOneThatCountsFromItsBeginning) {
  const std::vector<LogFrame> frames = RandomFrames(500, 4);
  std::vector<LogFrame> expected = frames;
  for (LogFrame& frame : expected) {
    frame.stamp_ns -= frames[0].stamp_ns;
  }
  for (const char stamp : {'z', 'd'}) {
    SCOPED_TRACE(stamp);
    ExpectFrames(Read(CandumpText(frames, stamp)).frames, expected, expected.size());
  }
  // Three frames do not tell; the option does.
  const std::string few = CandumpText({frames[0], frames[1], frames[2]}, 'd');
  ExpectFrames(Read(few, {.deltas = true}).frames, expected, 3);
}

TEST(LogReader, GivesFramesWithoutTimesWhereTheLogHasNone) {
  const std::vector<LogFrame> frames = OneOfEach();
  const ReadLog read = Read(CandumpText(frames, '\0'));
  ASSERT_EQ(read.frames.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_TRUE(SameOnTheWire(read.frames[i], frames[i]));
    EXPECT_FALSE(read.frames[i].stamped);
  }
}

TEST(LogReader, ReadsLogsThatOthersMade) {
  const struct {
    const char* file;
    std::size_t frames;
  } cases[] = {{"agilex_real_fragments.log", 9},
               {"canopen_csv_startup.log", 147},
               {"tracer_sdk_client.log", 4}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.file);
    const ReadLog read = Read(ReadFile(std::string(PIPEWRIGHT_TEST_DATA) + "/can/" + c.file));
    EXPECT_EQ(read.frames.size(), c.frames);
    EXPECT_TRUE(read.problems.none());
  }
}

}  // namespace
}  // namespace pipewright::hil
