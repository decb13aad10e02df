// SPDX-License-Identifier: MIT
#include "platform/can/candump.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <sstream>
#include <string>

#include "platform/core/rng.h"

namespace pipewright::can {
namespace {

std::string Line(const Frame& frame, std::string_view interface = "can0") {
  std::array<char, kCandumpLineBytes> buffer{};
  const Result<int> length = FormatCandump(frame, interface, buffer);
  return length.ok() ? std::string(buffer.data(), static_cast<std::size_t>(*length))
                     : Name(length.status());
}

TEST(Candump, ForeignLogsComeBackByteForByte) {
  for (const char* name :
       {"agilex_real_fragments.log", "canopen_csv_startup.log", "tracer_sdk_client.log"}) {
    std::ifstream file(std::string(PIPEWRIGHT_TEST_DATA "/can/") + name);
    std::stringstream text;
    text << file.rdbuf();
    const std::string content = text.str();
    ASSERT_FALSE(content.empty()) << name;
    std::string written;
    CandumpReader reader(content);
    for (Result<CandumpLine> r = reader.Next(); r.ok(); r = reader.Next()) {
      written += Line(r->frame, r->interface);
    }
    EXPECT_EQ(written, content) << name;
  }
}

TEST(Candump, ReadsWhatToolsWrite) {
  struct Case {
    const char* text;
    Frame frame;
    std::int64_t stamp_ns;
  };
  const Case kCases[] = {
      {"(1.000002) can0 080#", {.id = 0x080}, 1'000'002'000},
      {"(0000000001.000002003) can0 080#", {.id = 0x080}, 1'000'002'003},
      {"(1.000000) vcan0 123#R", {.id = 0x123, .remote = true}, 1'000'000'000},
      {"(1.000000) vcan0 123#R4", {.id = 0x123, .dlc = 4, .remote = true}, 1'000'000'000},
      {"(1.000000) can0 00000123#0a",
       {.id = 0x123, .dlc = 1, .extended = true, .data = {10}},
       1'000'000'000},
      {"(1.000000) can0 20000040#0000000000000000",
       {.id = 0x40, .dlc = 8, .error = true},
       1'000'000'000},
      {"(1.000000) can0 111#FF R", {.id = 0x111, .dlc = 1, .data = {255}}, 1'000'000'000},
      {"(1.000000)  can0  111#FF T\r", {.id = 0x111, .dlc = 1, .data = {255}}, 1'000'000'000},
  };
  for (const Case& c : kCases) {
    const Result<CandumpLine> r = ParseCandump(c.text);
    ASSERT_TRUE(r.ok()) << c.text;
    EXPECT_EQ(r->frame, c.frame) << c.text;
    EXPECT_EQ(r->frame.stamp.time_since_epoch().count(), c.stamp_ns) << c.text;
  }
}

TEST(Candump, RefusesWhatIsNotALine) {
  for (const char* text : {"",
                           "(",
                           "(1.0) can0 123#",
                           "(1.00000000) can0 123#",
                           "(x.000000) can0 123#",
                           "(1.000000 can0 123#",
                           "(1.000000)can0 123#",
                           "(1.000000) can0",
                           "(1.000000) can0 123",
                           "(1.000000) can0 12#",
                           "(1.000000) can0 1234#",
                           "(1.000000) can0 800#",
                           "(1.000000) can0 40000000#",
                           "(1.000000) can0 123#0",
                           "(1.000000) can0 123#0G",
                           "(1.000000) can0 123#112233445566778899",
                           "(1.000000) can0 123##1AA",
                           "(1.000000) can0 123#R9",
                           "(1.000000) can0 123#R44",
                           "(9999999999.000000) can0 123#",
                           "(-1.000000) can0 123#"}) {
    EXPECT_EQ(ParseCandump(text).status(), Status::kMalformed) << text;
  }
}

TEST(Candump, AnErrorNamesItsLineAndReadingGoesOn) {
  CandumpReader reader("# a comment\n(1.000000) can0 123#\n\n(1.0) bad\n(2.000000) can0 124#");
  EXPECT_TRUE(reader.Next().ok());
  EXPECT_EQ(reader.line(), 2);
  EXPECT_EQ(reader.Next().status(), Status::kMalformed);
  EXPECT_EQ(reader.line(), 4);
  EXPECT_EQ(reader.Next()->frame.id, 0x124U);
  EXPECT_EQ(reader.Next().status(), Status::kUnavailable);
}

TEST(Candump, AnyFrameComesBack) {
  Rng rng(3);
  for (int i = 0; i < 20'000; ++i) {
    Frame frame{.dlc = static_cast<std::uint8_t>(rng.Index(9))};
    const int kind = rng.Index(4);
    frame.extended = kind == 1;
    frame.remote = kind == 2;
    frame.error = kind == 3;
    frame.id =
        static_cast<std::uint32_t>(rng.Index(frame.extended || frame.error ? 0x20000000 : 0x800));
    for (int b = 0; b < frame.dlc && !frame.remote; ++b) {
      frame.data[static_cast<std::size_t>(b)] = static_cast<std::uint8_t>(rng.Index(256));
    }
    frame.stamp = Time(std::chrono::microseconds(rng.Index(2'000'000'000)));
    const std::string line = Line(frame);
    const Result<CandumpLine> back = ParseCandump(line.substr(0, line.size() - 1));
    ASSERT_TRUE(back.ok()) << line;
    ASSERT_EQ(back->frame, frame) << line;
    ASSERT_EQ(back->frame.stamp, frame.stamp) << line;
  }
}

TEST(Candump, AnyTextIsTakenWithoutHarm) {
  Rng rng(5);
  constexpr std::string_view kLetters = "(). 0123456789ABCDEFxR#\n\tcan";
  for (int i = 0; i < 50'000; ++i) {
    std::string text = "(1.000000) can0 111#01";
    for (int edits = rng.Index(6); edits >= 0; --edits) {
      text[static_cast<std::size_t>(rng.Index(static_cast<int>(text.size())))] =
          kLetters[static_cast<std::size_t>(rng.Index(static_cast<int>(kLetters.size())))];
    }
    (void)ParseCandump(text);
    (void)ParseCandump(std::string_view(text).substr(0, rng.Index(24)));
  }
}

TEST(Candump, WritesOnlyWhatFitsAndWhatALineCanHold) {
  std::array<char, 20> small{};
  EXPECT_EQ(FormatCandump({.id = 1}, "can0", small).status(), Status::kFull);
  EXPECT_EQ(Line({.id = 1}, ""), "malformed");
  EXPECT_EQ(Line({.id = 1}, "a name that is too long"), "malformed");
  EXPECT_EQ(Line({.id = 1}, "ca n"), "malformed");
  EXPECT_EQ(Line({.id = 0x800}), "malformed");
  EXPECT_EQ(Line({.id = 1, .dlc = 9}), "malformed");
  const Frame longest{.id = 0x1FFFFFFF,
                      .dlc = 8,
                      .extended = true,
                      .stamp = Time(std::chrono::seconds(9'000'000'000))};
  EXPECT_LT(Line(longest, "a23456789012345").size(), static_cast<std::size_t>(kCandumpLineBytes));
}

}  // namespace
}  // namespace pipewright::can
