// SPDX-License-Identifier: MIT
#include "hil/canlog/asc_lines.h"

#include "tests/hil/canlog/read_log.h"

namespace pipewright::hil {
namespace {

using namespace test;

constexpr const char* kHead = "date Sat Sep 30 15:06:13.191 2017\nbase hex  timestamps absolute\n";

TEST(AscLines, ReadsTheKindsOfEventsThatToolsWrite) {
  // Lines after Vector's description of the format, with the variations seen in files.
  const ReadLog read = Read(
      std::string(kHead) +
      "no internal events logged\n"
      "// version 9.0.0\n"
      "Begin Triggerblock Sam Sep 30 15:06:13.191 2017\n"
      "   0.000000 Start of measurement\n"
      "   0.015991 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0\n"
      "   1.015991 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%\n"
      "   2.501000 1 ErrorFrame\n"
      "   2.501020 2 ErrorFrame Flags = 0xe CodeExt = 0x20a2 Code = 0x82 ID = 0 DLC = 0\n"
      "   2.510001 2 100 Tx r\n"
      "   2.584921 4 300 Rx r 8 Length = 1704000 BitCount = 145 ID = 88888888x\n"
      "   3.098426 1  18EBFF00x       Rx d 8 01 A0 0F A6 60 3B D1 40    Length = 273910\n"
      "   3.297743 1  J1939TP FEE3p        6    0  0   -   Rx   d 23 A0 0F A6 60\n"
      "  13.258671 1  3FF             Tx   d D 55 AA 01 02 03 04 05 06  Length = 232016\n"
      "  13.300000 1  3FE             TxRq d 1 55\n"
      "  30.005071 CANFD   2 Rx        300  Generic_Name_12                  1 0 8  8 01 02 03 04 "
      "05 06 07 08   102203  133   303000 e0006659 46500250 4b140250 20011736 2001040d\n"
      "  30.300981 CANFD   3 Tx     50005x                                0 1 5 0 140000 73 200050 "
      "7a60 46500250 460a0250 20011736 20010205\n"
      "  30.806898 CANFD   5 Tx ErrorFrame Not Acknowledge error, dominant error flag fffe\n"
      "  31.000000 SV: 1 0 0 ::Panel::Speed = 3\n"
      "End TriggerBlock\n");
  ASSERT_TRUE(read.problems.none()) << read.problems.told()[0];
  std::vector<LogFrame> expected = {
      DataFrame(0x80, {0, 0, 0, 0, 0, 0, 0, 0}, 2'501'000'000),
      DataFrame(0x80, {0, 0, 0, 0, 0, 0, 0, 0}, 2'501'020'000),
      DataFrame(0x100, {}, 2'510'001'000),
      DataFrame(0x300, {0, 0, 0, 0, 0, 0, 0, 0}, 2'584'921'000),
      DataFrame(0x18EBFF00, {1, 0xA0, 0x0F, 0xA6, 0x60, 0x3B, 0xD1, 0x40}, 3'098'426'000),
      DataFrame(0x3FF, {0x55, 0xAA, 1, 2, 3, 4, 5, 6}, 13'258'671'000),
      DataFrame(0x300, {1, 2, 3, 4, 5, 6, 7, 8}, 30'005'071'000),
      DataFrame(0x50005, {0, 0, 0, 0, 0}, 30'300'981'000),
      DataFrame(0x80, {0, 0, 0, 0, 0, 0, 0, 0}, 30'806'898'000),
  };
  expected[0].error = expected[1].error = expected[8].error = true;
  expected[2].remote = expected[3].remote = true;
  expected[4].extended = expected[7].extended = true;
  expected[6].fd = expected[6].bitrate_switch = true;
  expected[7].remote = true;  // its flags 200050 say so, and that it is classic
  ExpectFrames(read.frames, expected, expected.size());
  EXPECT_EQ(read.channels, (std::vector<std::string>{"1", "2", "4", "3", "5"}));
  EXPECT_EQ(read.frames[2].direction, LogDirection::kSent);
  EXPECT_EQ(read.frames[3].direction, LogDirection::kReceived);
}

TEST(AscLines, ReadsLongFdFramesWhateverTheirFlags) {
  std::string line = "  30.506898 CANFD   4 Rx        4EE                   0 1 f 64";
  std::vector<int> payload;
  for (int i = 0; i < 64; ++i) {
    payload.push_back(i);
    line += fmt::format(" {:02x}", i);
  }
  const ReadLog read = Read(kHead + line + " 1331984 11 0 46500250 460a0250 20011736 20010205\n");
  LogFrame expected = DataFrame(0x4EE, payload, 30'506'898'000);
  expected.fd = expected.error_passive = true;
  ExpectFrames(read.frames, {expected}, 1);
}

TEST(AscLines, ReadsDecimalNumbersAndTimesSinceTheEventBefore) {
  const ReadLog read = Read(
      "date Sat Sep 30 10:06:13 pm 2017\nbase dec timestamps relative\n"
      "0.500000 Start of measurement\n"
      "1.000000 1 291 Rx d 2 10 255\n"
      "0.250000 CAN 1 Status:chip status error active\n"
      "0.250000 1 536870911x Rx d 0\n");
  ASSERT_TRUE(read.problems.none()) << read.problems.told()[0];
  LogFrame second = DataFrame(0x1FFFFFFF, {}, 2'000'000'000);
  second.extended = true;
  ExpectFrames(read.frames, {DataFrame(0x123, {10, 255}, 1'500'000'000), second}, 2);
}

TEST(AscLines, SaysWhatItExpected) {
  const struct {
    const char* line;
    const char* expected;
  } cases[] = {
      {"Monday", "a time in seconds"},
      {"1 1 123 Rx d 0", "a time in seconds"},
      {"1.0", "an event"},
      {"1.0 1234 123 Rx d 0", "a channel's number"},
      {"1.0 1 12G Rx d 0", "an id"},
      {"1.0 1 800 Rx d 0", "an id"},
      {"1.0 1 20000000x Rx d 0", "an id"},
      {"1.0 1", "an id"},
      {"1.0 1 123 Up d 0", "Rx or Tx"},
      {"1.0 1 123 Rx q 0", "d or r"},
      {"1.0 1 123 Rx d", "a length code"},
      {"1.0 1 123 Rx d 10", "a length code"},
      {"1.0 1 123 Rx d 2 01", "as many bytes"},
      {"1.0 1 123 Rx d 1 001", "as many bytes"},
      {"1.0 CANFD x Rx 123 0 0 1 1 01", "a channel's number and Rx or Tx"},
      {"1.0 CANFD 1 Rx 12345 0 0 1 1 01", "an id"},
      {"1.0 CANFD 1 Rx 123 Name 2 0 1 1 01", "two bits"},
      {"1.0 CANFD 1 Rx 123 0 0 9 9 01", "two bits"},
      {"1.0 CANFD 1 Rx 123 0 0 2 2 01", "as many bytes"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.line);
    const ReadLog read = Read(std::string(kHead) + c.line + "\n");
    ASSERT_EQ(read.problems.malformed(), 1U);
    EXPECT_NE(read.problems.told()[0].find(std::string("line 3: expected ") + c.expected),
              std::string::npos)
        << read.problems.told()[0];
  }
}

TEST(AscLines, KeepsTheSumOfRelativeTimesATime) {
  std::string text = "base hex timestamps relative\n";
  for (int i = 0; i < 5; ++i) {
    text += "8999999999.999999 1 123 Rx d 0\n";
  }
  const ReadLog read = Read(text);
  ASSERT_EQ(read.frames.size(), 5U);
  EXPECT_EQ(read.frames[4].stamp_ns, std::numeric_limits<std::int64_t>::max());
}

}  // namespace
}  // namespace pipewright::hil
