// SPDX-License-Identifier: MIT
#include "node_bench.h"

namespace pipewright::hil {
namespace {

using Answer = std::array<std::uint8_t, 8>;

// Abort codes as CiA 301 prints them, low byte first.
TEST(SdoServer, AnswersEveryRefusalWithTheStandardsCode) {
  struct Case {
    const char* name;
    std::initializer_list<int> request;
    std::uint32_t code;
  };
  const Case cases[] = {
      {"no such object", {0x40, 0x34, 0x12, 0, 0, 0, 0, 0}, 0x06020000},
      {"no such subindex", {0x40, 0x18, 0x10, 9, 0, 0, 0, 0}, 0x06090011},
      {"write to a read-only one", {0x2B, 0x41, 0x60, 0, 1, 0, 0, 0}, 0x06010002},
      {"too long", {0x23, 0x40, 0x60, 0, 6, 0, 0, 0}, 0x06070012},
      {"too short", {0x2F, 0x40, 0x60, 0, 6, 0, 0, 0}, 0x06070013},
      {"mode not supported", {0x2F, 0x60, 0x60, 0, 1, 0, 0, 0}, 0x06090030},
      {"value too high", {0x2B, 0x07, 0x60, 0, 4, 0, 0, 0}, 0x06090031},
      {"value too low", {0x2B, 0x07, 0x60, 0, 0xFF, 0xFF, 0, 0}, 0x06090032},
      {"segmented download", {0x21, 0x40, 0x60, 0, 2, 0, 0, 0}, 0x05040001},
      {"a segment", {0x60, 0, 0, 0, 0, 0, 0, 0}, 0x05040001},
      {"block upload", {0xA0, 0x40, 0x60, 0, 0, 0, 0, 0}, 0x05040001},
      {"map a PDO that is on", {0x2F, 0x01, 0x1A, 0, 0, 0, 0, 0}, 0x06010000},
      {"entry while the count is not 0", {0x23, 0, 0x16, 1, 0x10, 0, 0x40, 0x60}, 0x06010000},
      {"extended PDO id", {0x23, 0, 0x14, 1, 1, 2, 0, 0xA0}, 0x06090030},
      {"restricted PDO id", {0x23, 0, 0x14, 1, 0x01, 0x06, 0, 0x80}, 0x06090030},
      {"RTR-only type", {0x2F, 0, 0x18, 2, 0xFD, 0, 0, 0}, 0x06090030},
  };
  NodeBench bench;
  bench.Run(60);
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Answer answer = bench.Ask(c.request);
    EXPECT_EQ(answer[0], 0x80);
    const std::vector<int> request(c.request);
    for (std::size_t i = 1; i <= 3; ++i) {
      EXPECT_EQ(answer[i], request[i]);
    }
    const std::uint32_t code =
        answer[4] | answer[5] << 8 | answer[6] << 16 | static_cast<std::uint32_t>(answer[7]) << 24;
    EXPECT_EQ(code, c.code);
  }
}

TEST(SdoServer, RefusesMappingsThatNoPduCanCarry) {
  NodeBench bench;
  bench.Run(60);
  ASSERT_TRUE(bench.Write(0x1A00, 0, 1, 0));
  EXPECT_EQ(bench.Ask({0x23, 0, 0x1A, 1, 0x10, 0, 0x40, 0x60})[4], 0x41);  // 6040h: receive only
  EXPECT_EQ(bench.Ask({0x23, 0, 0x1A, 1, 0x08, 0, 0x64, 0x60})[4], 0x41);  // 6064h has 32 bits
  EXPECT_EQ(bench.Ask({0x23, 0, 0x1A, 1, 0x20, 0, 0x99, 0x60})[6], 0x02);  // no such object
  EXPECT_TRUE(bench.Write(0x1A00, 1, 4, 0x60640020));
  EXPECT_TRUE(bench.Write(0x1A00, 2, 4, 0x606C0020));
  EXPECT_TRUE(bench.Write(0x1A00, 3, 4, 0x60410010));
  EXPECT_EQ(bench.Ask({0x2F, 0, 0x1A, 0, 3, 0, 0, 0}), (Answer{0x80, 0, 0x1A, 0, 0x42, 0, 4, 6}));
  EXPECT_EQ(bench.Ask({0x2F, 0, 0x1A, 0, 9, 0, 0, 0}), (Answer{0x80, 0, 0x1A, 0, 0x42, 0, 4, 6}));
  EXPECT_TRUE(bench.Write(0x1A00, 0, 1, 2));
  EXPECT_EQ(bench.Ask({0x2F, 0, 0x1A, 0, 4, 0, 0, 0})[0], 0x80);  // an entry that is empty
}

TEST(SdoServer, SaysItsUnitsModesAndLimits) {
  NodeBench bench(Cia402Config{.lower_rad = -1.5, .upper_rad = 2.25});
  bench.Run(60);
  EXPECT_EQ(bench.Ask({0x40, 0x02, 0x65, 0, 0, 0, 0, 0}), (Answer{0x43, 2, 0x65, 0, 0, 1, 0, 0}));
  EXPECT_EQ(bench.Ask({0x40, 0xA8, 0x60, 0, 0, 0, 0, 0}),
            (Answer{0x43, 0xA8, 0x60, 0, 0, 0, 0x10, 0xFA}));
  EXPECT_EQ(bench.Ask({0x40, 0xA9, 0x60, 0, 0, 0, 0, 0}),
            (Answer{0x43, 0xA9, 0x60, 0, 0, 3, 0x10, 0xFA}));
  const ObjectDictionary& od = bench.node.dictionary();
  EXPECT_EQ(od.Find(0x607D, 1)->Signed(), -1500000);
  EXPECT_EQ(od.Find(0x607D, 2)->Signed(), 2250000);
  EXPECT_EQ(od.Value(0x6080, 0), 30U);  // rpm: pi rad/s
}

TEST(SdoServer, TakesADownloadWithoutASize) {
  NodeBench bench;
  bench.Run(60);
  EXPECT_EQ(bench.Ask({0x22, 0x60, 0x60, 0, 9, 0, 0, 0})[0], 0x60);
  EXPECT_EQ(bench.node.dictionary().Value(0x6061, 0), 9U);
}

TEST(SdoServer, IsSilentWhenStoppedAndOnShortFrames) {
  NodeBench bench;
  bench.Run(60);
  bench.Hear(Bytes(0x601, {0x40, 0x41, 0x60, 0}));
  bench.Tick();
  EXPECT_EQ(bench.node.rejected(), 1);
  bench.Hear(Bytes(0x000, {0x02, 0x00}));
  bench.Hear(Bytes(0x601, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}));
  bench.Run(5);
  EXPECT_TRUE(bench.Said(0x581).empty());
}

TEST(SdoServer, TheErrorHistoryFillsAndIsClearedByWritingZero) {
  NodeBench bench;
  bench.Run(60);
  bench.node.RaiseInternalFault(0x2310);
  bench.Tick();
  bench.node.RaiseInternalFault(0x4210);
  bench.Tick();
  const ObjectDictionary& od = bench.node.dictionary();
  EXPECT_EQ(od.Value(0x1003, 0), 2U);
  EXPECT_EQ(od.Value(0x1003, 1), 0x4210U);
  EXPECT_EQ(od.Value(0x1003, 2), 0x2310U);
  EXPECT_FALSE(bench.Write(0x1003, 0, 1, 1));
  EXPECT_TRUE(bench.Write(0x1003, 0, 1, 0));
  EXPECT_EQ(od.Value(0x1003, 1), 0U);
}

}  // namespace
}  // namespace pipewright::hil
