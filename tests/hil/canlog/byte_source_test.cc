// SPDX-License-Identifier: MIT
#include "hil/canlog/byte_source.h"

#include "hil/canlog/byte_window.h"
#include "tests/hil/canlog/read_log.h"

namespace pipewright::hil {
namespace {

using namespace test;

std::string All(ByteSource& source, std::size_t step) {
  std::string all;
  std::string part(step, '\0');
  for (std::size_t got = source.Read(part); got > 0; got = source.Read(part)) {
    all += part.substr(0, got);
  }
  return all;
}

std::filesystem::path File(const std::string& bytes) {
  static const std::filesystem::path folder = TestFolder();
  WriteFile(folder / "bytes", bytes);
  return folder / "bytes";
}

std::string Noise(std::size_t bytes) {
  Rng rng(9);
  std::string text(bytes, '\0');
  for (char& c : text) {
    c = static_cast<char>(rng.Index(40));
  }
  return text;
}

TEST(ByteSource, GivesTheSameBytesHoweverTheyArePacked) {
  const std::string text = Noise(300'000);
  const struct {
    const char* packing;
    std::string bytes;
  } cases[] = {
      {"none", text},
      {"gz", Gz(text)},
      {"gz", Gz(text.substr(0, 1000)) + Gz(text.substr(1000))},  // as `cat a.gz b.gz` makes
      {"zstd", Zstd(text)},
      {"zstd", Zstd(text.substr(0, 1000)) + Zstd(text.substr(1000))},
  };
  for (const auto& c : cases) {
    for (const std::size_t step : {7U, 4096U, 1U << 20}) {
      SCOPED_TRACE(testing::Message() << c.packing << ", " << step);
      const std::filesystem::path path = File(c.bytes);
      ByteSource source;
      ASSERT_EQ(source.Open(path.string()), "");
      EXPECT_STREQ(source.packing(), c.packing);
      EXPECT_EQ(All(source, step), text);
      EXPECT_EQ(source.error(), "");
      EXPECT_EQ(source.file_position(), c.bytes.size());
      EXPECT_EQ(source.file_size(), c.bytes.size());
    }
  }
}

TEST(ByteSource, IsCertainOfWhatAChecksumCameBehind) {
  const std::string first = Noise(1000);
  const std::string second = Noise(70'000);
  const auto certain = [](const std::string& bytes) {
    ByteSource source;
    EXPECT_EQ(source.Open(File(bytes)), "");
    All(source, 100);
    return source.certain();
  };
  EXPECT_EQ(certain(first), first.size());
  for (const auto& pack : {Gz, Zstd}) {
    const std::string one = pack(first);
    const std::string both = one + pack(second);
    EXPECT_EQ(certain(both), first.size() + second.size());
    EXPECT_EQ(certain(both.substr(0, both.size() - 1)), first.size());
    EXPECT_EQ(certain(both.substr(0, one.size() + 1)), first.size());
    EXPECT_EQ(certain(both.substr(0, one.size())), first.size());
    EXPECT_EQ(certain(both.substr(0, one.size() - 1)), 0U);
  }
}

TEST(ByteSource, SaysWherePackedDataStopOrMakeNoSense) {
  const std::string text = Noise(100'000);
  for (const std::string& packed : {Gz(text), Zstd(text)}) {
    ByteSource cut;
    ASSERT_EQ(cut.Open(File(packed.substr(0, packed.size() - 1)).string()), "");
    All(cut, 4096);
    EXPECT_NE(cut.error().find("stop short at byte " + std::to_string(packed.size() - 1)),
              std::string::npos)
        << cut.error();
    ByteSource noise;
    ASSERT_EQ(noise.Open(File(packed + "then something else").string()), "");
    EXPECT_EQ(All(noise, 4096).substr(0, text.size()), text);
    EXPECT_NE(noise.error().find("make no sense"), std::string::npos) << noise.error();
  }
}

TEST(ByteWindow, GivesLinesOfAnyLengthUpToItsMost) {
  std::string text = "first\r\n\nthird\n";
  text += std::string(ByteWindow::kMostLine - 1, 'a') + "\n";
  text += std::string(ByteWindow::kMostLine, 'b') + "\n";
  text += std::string(3 * ByteWindow::kBytes, 'c') + "\n";
  text += "last";
  ByteSource source;
  ASSERT_EQ(source.Open(File(text).string()), "");
  ByteWindow window(source);
  std::string_view line;
  using Kind = ByteWindow::LineKind;
  for (const std::string& expected : {std::string("first"), std::string(), std::string("third"),
                                      std::string(ByteWindow::kMostLine - 1, 'a')}) {
    EXPECT_EQ(window.Line(line), Kind::kWhole);
    EXPECT_EQ(line, expected);
  }
  EXPECT_EQ(window.Line(line), Kind::kTooLong);
  EXPECT_EQ(window.Line(line), Kind::kTooLong);
  EXPECT_EQ(window.lines(), 6U);
  EXPECT_EQ(window.Line(line), Kind::kCut);
  EXPECT_EQ(line, "last");
  EXPECT_EQ(window.Line(line), Kind::kEnd);
  EXPECT_EQ(window.lines(), 7U);
  EXPECT_EQ(window.position(), text.size());
}

TEST(ByteWindow, SkipsBeyondItself) {
  const std::string text = Noise(3 * ByteWindow::kBytes);
  ByteSource source;
  ASSERT_EQ(source.Open(File(text).string()), "");
  ByteWindow window(source);
  EXPECT_EQ(window.Peek(4), text.substr(0, 4));
  EXPECT_EQ(window.Skip(2 * ByteWindow::kBytes + 5), 2 * ByteWindow::kBytes + 5);
  EXPECT_EQ(window.Peek(4), text.substr(2 * ByteWindow::kBytes + 5, 4));
  EXPECT_EQ(window.Skip(text.size()), ByteWindow::kBytes - 5);
  EXPECT_EQ(window.Peek(4), "");
}

}  // namespace
}  // namespace pipewright::hil
