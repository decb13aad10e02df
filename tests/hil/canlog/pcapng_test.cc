// SPDX-License-Identifier: MIT
#include "hil/canlog/pcapng_blocks.h"
#include "tests/hil/canlog/read_log.h"

namespace pipewright::hil {
namespace {

using namespace test;

std::string Section(bool big) {
  CaptureBytes section(big);
  section.Put(0x1A2B3C4D, 4).Put(1, 2).Put(0, 2).Put(~std::uint64_t{0}, 8);
  return PcapngBlock(big, 0x0A0D0D0A, section.text);
}

/// `options`: in front of their end.
std::string Interface(bool big, int link_type, const std::string& options = "") {
  CaptureBytes interface(big);
  interface.Put(static_cast<std::uint64_t>(link_type), 2).Put(0, 2).Put(0, 4).Text(options);
  return PcapngBlock(big, 1, interface.Put(0, 4).text);
}

std::string Option(bool big, int code, const std::string& value) {
  CaptureBytes option(big);
  option.Put(static_cast<std::uint64_t>(code), 2).Put(value.size(), 2).Text(value);
  return option.text;
}

std::string Packet(bool big, std::uint32_t interface, std::uint64_t time, const LogFrame& frame,
                   std::uint32_t flags = 0) {
  const std::string bytes = SocketCanPacket(frame);
  CaptureBytes packet(big);
  packet.Put(interface, 4).Put(time >> 32, 4).Put(time & 0xFFFFFFFF, 4);
  packet.Put(bytes.size(), 4).Put(bytes.size(), 4).Text(bytes);
  packet.Put(2, 2).Put(4, 2).Put(flags, 4).Put(0, 4);
  return PcapngBlock(big, 6, packet.text);
}

TEST(PcapngBlocks, ReadsSeveralInterfacesUnitsOfTimeAndSections) {
  const LogFrame a = DataFrame(0x123, {1, 2, 3});
  CaptureBytes offset(true);
  offset.Put(1000, 8);
  CaptureBytes simple(false);
  simple.Put(16, 4).Text(SocketCanPacket(a));
  CaptureBytes obsolete(false);
  obsolete.Put(0, 2).Put(7, 2).Put(0, 4).Put(5'000'000, 4).Put(16, 4).Put(16, 4);
  obsolete.Text(SocketCanPacket(a)).Put(0, 4);
  const std::string bytes =
      Section(true) + Interface(true, 1) +  // Ethernet
      Interface(true, 227, Option(true, 2, "can7") + Option(true, 14, offset.text)) +
      Interface(true, 227, Option(true, 9, "\x8A")) +          // 2^-10 s
      PcapngBlock(true, 0x0BAD, "what no one knows, 24 by") +  //
      Packet(true, 1, 2'000'001, a, 2) + Packet(true, 0, 1, a) + Packet(true, 2, 1536, a, 1) +
      Section(false) + Interface(false, 227, Option(false, 9, "\x03")) +  // ms
      Packet(false, 0, 1500, a) + PcapngBlock(false, 3, simple.text) +
      PcapngBlock(false, 2, obsolete.text);
  const ReadLog read = Read(bytes);
  ASSERT_TRUE(read.problems.none()) << read.problems.end();
  ASSERT_EQ(read.frames.size(), 5U);
  EXPECT_EQ(read.channels, (std::vector<std::string>{"can7", "can2", "can0"}));
  const std::int64_t stamps[] = {1002'000'001'000, 1'500'000'000, 1'500'000'000, 0,
                                 5000'000'000'000};
  for (std::size_t i = 0; i < 5; ++i) {
    SCOPED_TRACE(i);
    EXPECT_TRUE(SameOnTheWire(read.frames[i], a));
    EXPECT_EQ(read.frames[i].stamp_ns, stamps[i]);
    EXPECT_EQ(read.frames[i].stamped, i != 3);
  }
  EXPECT_EQ(read.frames[0].direction, LogDirection::kSent);
  EXPECT_EQ(read.frames[1].direction, LogDirection::kReceived);
}

TEST(PcapngBlocks, SaysThatNoInterfaceIsSocketCan) {
  const std::string bytes = Section(false) + Interface(false, 252) + Interface(false, 1) +
                            Packet(false, 0, 0, DataFrame(1, {}));
  const ReadLog read = Read(bytes);
  EXPECT_TRUE(read.frames.empty());
  EXPECT_EQ(read.problems.end(), "holds link type 252; expected an interface of 227, SocketCAN");
}

TEST(PcapngBlocks, GivesEveryNanosecond) {
  Rng rng(11);
  for (int k = 0; k < 200; ++k) {
    const std::int64_t ns = 1'700'000'000'000'000'000 + static_cast<std::int64_t>(rng.Next() >> 12);
    const ReadLog read = Read(Pcapng({DataFrame(1, {}, ns)}, false, true));
    ASSERT_EQ(read.frames.size(), 1U);
    EXPECT_EQ(read.frames[0].stamp_ns, ns);
  }
}

TEST(PcapngBlocks, SaysWhatItExpected) {
  const LogFrame a = DataFrame(0x123, {1});
  const std::string head = Section(false) + Interface(false, 227);
  const std::string good = Packet(false, 0, 0, a);
  const auto with = [](std::string bytes, std::size_t at, char value) {
    bytes[at] = value;
    return bytes;
  };
  const struct {
    std::string bytes;
    const char* malformed;
    const char* end;
    std::size_t frames;
  } cases[] = {
      {head + Packet(false, 1, 0, a) + good, "an interface that was described before", "", 1},
      {head + with(good, 8 + 12, 127) + good, "a packet that fits into its block", "", 1},
      {head + PcapngBlock(false, 6, "0123") + good, "a packet block of at least 32", "", 1},
      {head + Interface(false, 227, Option(false, 9, "\x7F")) + good, "a unit of time", "", 1},
      {head + PcapngBlock(false, 1, "0123") + good, "an interface of at least 8", "", 1},
      {head + good + with(good, 4, 9), nullptr, "expected a block's length", 1},
      {with(Section(false), 8, 0) + good, nullptr, "a section's byte order", 0},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.malformed == nullptr ? c.end : c.malformed);
    const ReadLog read = Read(c.bytes);
    EXPECT_EQ(read.frames.size(), c.frames);
    EXPECT_EQ(read.problems.malformed(), c.malformed == nullptr ? 0U : 1U);
    if (c.malformed != nullptr) {
      EXPECT_NE(read.problems.told()[0].find(c.malformed), std::string::npos)
          << read.problems.told()[0];
    }
    EXPECT_NE(read.problems.end().find(c.end), std::string::npos) << read.problems.end();
  }
}

}  // namespace
}  // namespace pipewright::hil
