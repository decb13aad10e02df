// SPDX-License-Identifier: MIT
#include "hil/canlog/pcap_packets.h"
#include "tests/hil/canlog/read_log.h"

namespace pipewright::hil {
namespace {

using namespace test;
using namespace std::string_literals;

TEST(SocketCanPacket, ReadsTheBytesThatTcpdumpOrgDescribes) {
  const struct {
    const char* what;
    std::string packet;
    std::uint32_t id;
    std::string payload;
    bool extended, remote, error, fd;
  } cases[] = {
      {"11 bits", "\0\0\1\x23\2\0\0\0\xAB\xCD\0\0\0\0\0\0"s, 0x123, "ABCD", false, false, false,
       false},
      {"29 bits", "\x9A\xBC\xDE\xF0\1\0\0\0\x11"s, 0x1ABCDEF0, "11", true, false, false, false},
      {"remote", "\x40\0\0\x11\4\0\0\0\0\0\0\0\0\0\0\0"s, 0x11, "", false, true, false, false},
      {"error", "\x20\0\0\x40\2\0\0\0\1\2"s, 0x40, "0102", false, false, true, false},
      {"FD by its flag", "\0\0\1\x23\1\4\0\0\xAB"s, 0x123, "AB", false, false, false, true},
      {"FD by its size", "\0\0\1\x23\1\0\0\0\xAB"s + std::string(63, '\0'), 0x123, "AB", false,
       false, false, true},
      {"FD by its length", "\0\0\1\x23\x0C\0\0\0"s + std::string(12, '\1'), 0x123,
       "010101010101010101010101", false, false, false, true},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    LogFrame frame = DataFrame(0, {});
    ASSERT_EQ(ReadSocketCanPacket(c.packet, frame), nullptr);
    EXPECT_EQ(frame.id, c.id);
    EXPECT_EQ(HexBytes(frame, ""), c.payload);
    EXPECT_EQ(frame.extended, c.extended);
    EXPECT_EQ(frame.remote, c.remote);
    EXPECT_EQ(frame.error, c.error);
    EXPECT_EQ(frame.fd, c.fd);
  }
}

TEST(SocketCanPacket, SaysWhatItExpected) {
  const struct {
    std::string packet;
    const char* expected;
  } cases[] = {
      {"\0\0\1"s, "at least 8 bytes"},
      {"\0\0\x08\0\0\0\0\0"s, "an id of 11 bits"},
      {"\0\0\1\x23\x09\4\0\0\0\0\0\0\0\0\0\0\0"s, "a length that CAN"},
      {"\0\0\1\x23\2\0\0\0\1"s, "as many payload bytes"},
      {"\0\0\1\x23\x80\0\0\0"s, "not CAN XL"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.expected);
    LogFrame frame = DataFrame(0, {});
    const char* const expected = ReadSocketCanPacket(c.packet, frame);
    ASSERT_NE(expected, nullptr);
    EXPECT_NE(std::string(expected).find(c.expected), std::string::npos) << expected;
  }
}

TEST(PcapPackets, RefusesOtherLinkTypesAndPacketsThatCannotBe) {
  std::string ethernet = Pcap({}, false, false);
  ethernet[20] = 1;
  EXPECT_EQ(Read(ethernet).problems.end(),
            "byte 20: is a capture of link type 1; expected 227, SocketCAN");
  std::string huge = Pcap({DataFrame(0x123, {1}), DataFrame(0x124, {1})}, false, false);
  huge[24 + 32 + 8 + 3] = 0x7F;
  const ReadLog read = Read(huge);
  EXPECT_EQ(read.frames.size(), 1U);
  EXPECT_NE(read.problems.end().find("byte 56: a packet of 2130706448 bytes"), std::string::npos)
      << read.problems.end();
}

TEST(PcapPackets, CountsAPacketThatIsNoFrameAndReadsOn) {
  std::string bytes =
      Pcap({DataFrame(0x123, {1}), DataFrame(0x124, {1}), DataFrame(0x125, {2})}, true, true);
  bytes[24 + 32 + 16 + 4] = 9;  // of 8 payload bytes, a length of 9
  const ReadLog read = Read(bytes);
  ASSERT_EQ(read.frames.size(), 2U);
  EXPECT_EQ(read.frames[1].id, 0x125U);
  EXPECT_EQ(read.problems.malformed(), 1U);
  EXPECT_EQ(read.problems.told()[0], "byte 56: expected a length that CAN or CAN FD has");
}

}  // namespace
}  // namespace pipewright::hil
