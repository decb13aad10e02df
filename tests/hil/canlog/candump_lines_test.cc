// SPDX-License-Identifier: MIT
#include "hil/canlog/candump_lines.h"

#include <gtest/gtest.h>

#include "hil/canlog/line_scanner.h"
#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

using Kind = LineMeaning::Kind;
using ReadLine = LineMeaning (*)(std::string_view, ChannelNames&, LogFrame&);

struct Good {
  const char* line;
  const char* channel;
  std::int64_t ns;
  std::uint32_t id;
  std::string payload;  ///< as HexBytes; of a remote frame: its length
  const char* flags;    ///< x extended, r remote, e error, f FD, b switch, p passive, R, T
};

std::string Flags(const LogFrame& f) {
  return std::string(f.extended ? "x" : "") + (f.remote ? "r" : "") + (f.error ? "e" : "") +
         (f.fd ? "f" : "") + (f.bitrate_switch ? "b" : "") + (f.error_passive ? "p" : "") +
         (f.direction == LogDirection::kReceived ? "R" : "") +
         (f.direction == LogDirection::kSent ? "T" : "");
}

void ExpectReads(ReadLine read, const Good& good) {
  SCOPED_TRACE(good.line);
  ChannelNames channels;
  LogFrame frame;
  const LineMeaning meaning = read(good.line, channels, frame);
  ASSERT_EQ(meaning.kind, Kind::kFrame) << meaning.expected;
  EXPECT_EQ(channels.Name(frame.channel), good.channel);
  EXPECT_EQ(frame.stamp_ns, good.ns);
  EXPECT_EQ(frame.id, good.id);
  EXPECT_EQ(frame.remote ? std::to_string(frame.length) : test::HexBytes(frame, ""), good.payload);
  EXPECT_EQ(Flags(frame), good.flags);
}

TEST(CandumpLogLine, ReadsWhatTheFormatHas) {
  const Good cases[] = {
      {"(1699000000.000000) can0 123#DEADBEEF", "can0", 1699000000'000000000, 0x123, "DEADBEEF",
       ""},
      {"(0000000000.000001) vcan12 080#", "vcan12", 1000, 0x80, "", ""},
      {"(1.123456789) c 7FF#1122334455667788", "c", 1'123456789, 0x7FF, "1122334455667788", ""},
      {"(1.000000) can0 1ABCDEF0#00", "can0", 1'000000000, 0x1ABCDEF0, "00", "x"},
      {"(1.000000) can0 00000001#aAbB", "can0", 1'000000000, 1, "AABB", "x"},
      {"(1.000000) can0 123#R", "can0", 1'000000000, 0x123, "0", "r"},
      {"(1.000000) can0 12345678#R8", "can0", 1'000000000, 0x12345678, "8", "xr"},
      {"(1.000000) can0 20000040#0000000000000000", "can0", 1'000000000, 0x40, "0000000000000000",
       "e"},
      {"(1.000000) can0 123##0", "can0", 1'000000000, 0x123, "", "f"},
      {"(1.000000) can0 123##1112233445566778899AABBCC", "can0", 1'000000000, 0x123,
       "112233445566778899AABBCC", "fb"},
      {"(1.000000) can0 00000123##311", "can0", 1'000000000, 0x123, "11", "xfbp"},
      {"(1.000000) can0 123##511", "can0", 1'000000000, 0x123, "11", "fb"},  // with FDF, 4
      {"(1.000000) can0 123#1122334455667788_E", "can0", 1'000000000, 0x123, "1122334455667788",
       ""},
      {"(1.000000) can0 123#11 R", "can0", 1'000000000, 0x123, "11", "R"},
      {"(1.000000)  can0\t123#11 T", "can0", 1'000000000, 0x123, "11", "T"},
      {"(1.000000) can0 123#11 anything else", "can0", 1'000000000, 0x123, "11", ""},
  };
  for (const Good& good : cases) {
    ExpectReads(ReadCandumpLogLine, good);
  }
}

TEST(CandumpLogLine, SaysWhatItExpected) {
  const struct {
    const char* line;
    const char* expected;
  } cases[] = {
      {"1699000000.000000 can0 123#", "a time such as"},
      {"(1699000000) can0 123#", "a time such as"},
      {"(1699000000.) can0 123#", "a time such as"},
      {"(9000000001.0) can0 123#", "a time such as"},
      {"(99999999999.0) can0 123#", "a time such as"},
      {"(1.0)can0 123#", "a time such as"},
      {"(1.0) ", "an interface"},
      {"(1.0) can0", "3 or 8 hex digits and '#'"},
      {"(1.0) can0 12#", "3 or 8 hex digits and '#'"},
      {"(1.0) can0 800#", "3 or 8 hex digits and '#'"},
      {"(1.0) can0 1234#", "3 or 8 hex digits and '#'"},
      {"(1.0) can0 FFFFFFFF#", "3 or 8 hex digits and '#'"},
      {"(1.0) can0 123", "3 or 8 hex digits and '#'"},
      {"(1.0) can0 123#1", "pairs of hex digits"},
      {"(1.0) can0 123#112233445566778899", "at most 8 bytes"},
      {"(1.0) can0 123#11.22", "pairs of hex digits"},
      {"(1.0) can0 123#R9", "at most 8 bytes"},
      {"(1.0) can0 123##", "CAN FD payload"},
      {"(1.0) can0 123##1112233445566778899", "CAN FD payload"},  // 9 bytes: no such length
      {"(1.0) can0 123#11_", "a length code"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.line);
    ChannelNames channels;
    LogFrame frame;
    const LineMeaning meaning = ReadCandumpLogLine(c.line, channels, frame);
    ASSERT_EQ(meaning.kind, Kind::kMalformed);
    EXPECT_NE(std::string(meaning.expected).find(c.expected), std::string::npos)
        << meaning.expected;
  }
}

TEST(CandumpLine, ReadsWhatCandumpPrints) {
  const Good cases[] = {
      {"  can0  123   [8]  DE AD BE EF 00 11 22 33", "can0", 0, 0x123, "DEADBEEF00112233", ""},
      {"  can0  080   [0] ", "can0", 0, 0x80, "", ""},
      {"  vcan0       123   [2]  01 02", "vcan0", 0, 0x123, "0102", ""},  // indented
      {"  can0  12345678   [1]  FF", "can0", 0, 0x12345678, "FF", "x"},
      {"  can0  123   [8]  remote request", "can0", 0, 0x123, "8", "r"},
      {"  can0  20000080   [8]  00 00 00 00 00 00 00 00   ERRORFRAME", "can0", 0, 0x80,
       "0000000000000000", "e"},
      {"  can0  123   [4]  41 42 43 44               'ABCD'", "can0", 0, 0x123, "41424344", ""},
      {"  can0  123  [12]  01 02 03 04 05 06 07 08 09 0A 0B 0C", "can0", 0, 0x123,
       "0102030405060708090A0B0C", "f"},
      {"  can0  123  [08]  01 02 03 04 05 06 07 08", "can0", 0, 0x123, "0102030405060708", "f"},
      {"  can0  123   [8]{E}  01 02 03 04 05 06 07 08", "can0", 0, 0x123, "0102030405060708", ""},
      {" (1699000000.123456)  can0  123   [1]  01", "can0", 1699000000'123456000, 0x123, "01", ""},
      {" (003.000125)  can0  123   [1]  01", "can0", 3'000125000, 0x123, "01", ""},
      {" (2023-11-03 08:26:40.123456)  can0  123   [1]  01", "can0", 1699000000'123456000, 0x123,
       "01", ""},
      {" (1970-01-01 00:00:00.000001)  can0  123   [1]  01", "can0", 1000, 0x123, "01", ""},
      {" (1.000000)  can0  TX - -  123   [1]  01", "can0", 1'000000000, 0x123, "01", "T"},
      {" (1.000000)  can0  RX B E  123  [01]  01", "can0", 1'000000000, 0x123, "01", "fbpR"},
  };
  for (const Good& good : cases) {
    ExpectReads(ReadCandumpLine, good);
  }
}

TEST(CandumpLine, SaysWhatItExpected) {
  const struct {
    const char* line;
    const char* expected;
  } cases[] = {
      {" (1)  can0  123   [1]  01", "a time such as"},
      {" (2023-13-03 09:26:40.1)  can0  123   [1]  01", "a time such as"},
      {" (2023-11-03 24:26:40.1)  can0  123   [1]  01", "a time such as"},
      {" (2023-02-30 09:26:40.1)  can0  123   [1]  01", "a time such as"},
      {" (1.0)", "an interface"},
      {"  can0  12   [1]  01", "an id"},
      {"  can0  123   1  01", "a length"},
      {"  can0  123   [9]  01 02 03 04 05 06 07 08 09", "a length"},
      {"  can0  123   [65]  01", "a length"},
      {"  can0  123   [2]  01", "as many bytes"},
      {"  can0  123   [2]  01 0G", "as many bytes"},
      {"  can0  123   [1]  00000001", "as many bytes"},  // -i: binary
      {"  can0  123   [2]  01`02", "as many bytes"},     // -S: in reverse
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.line);
    ChannelNames channels;
    LogFrame frame;
    const LineMeaning meaning = ReadCandumpLine(c.line, channels, frame);
    ASSERT_EQ(meaning.kind, Kind::kMalformed);
    EXPECT_NE(std::string(meaning.expected).find(c.expected), std::string::npos)
        << meaning.expected;
  }
}

TEST(CandumpLine, PassesOverTheExplanationOfAnErrorMessage) {
  ChannelNames channels;
  LogFrame frame;
  EXPECT_EQ(ReadCandumpLine("\tcontroller-problem{rx-overflow}", channels, frame).kind,
            Kind::kNothing);
  EXPECT_EQ(ReadCandumpLine("", channels, frame).kind, Kind::kNothing);
}

TEST(ChannelNames, NumbersThemAsTheyComeAndSharesTheLastNumber) {
  ChannelNames channels;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(int{channels.Number("can" + std::to_string(i))}, std::min(i, 255));
  }
  EXPECT_EQ(channels.size(), 256);
  EXPECT_EQ(channels.Name(254), "can254");
  EXPECT_EQ(channels.Name(255), "others");
  EXPECT_EQ(int{channels.Number("can7")}, 7);
}

}  // namespace
}  // namespace pipewright::hil
