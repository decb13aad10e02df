// SPDX-License-Identifier: MIT
#include "hil/mcap/mcap_writer.h"

#include <gtest/gtest.h>

#include "tests/support/command.h"

namespace pipewright::hil {
namespace {

using namespace test;

TEST(McapWriter, SaysThatAFileCannotBeMade) {
  McapWriter writer;
  EXPECT_EQ(writer.Open("/nowhere/at/all.mcap", "ros2"), "No such file or directory");
}

TEST(McapWriter, SaysThatTheDiskIsFull) {
  McapWriter writer;
  ASSERT_EQ(writer.Open("/dev/full", ""), "");
  const std::uint16_t channel = writer.AddChannel(writer.AddSchema("a", "", ""), "/a", "");
  // What cannot be packed: after a chunk or two the buffers of the C library are full, too.
  std::string noise(McapWriter::kChunkBytes / 4, '\0');
  std::uint32_t random = 1;
  for (int message = 0; message < 12; ++message) {
    for (char& byte : noise) {
      random = random * 1664525 + 1013904223;
      byte = static_cast<char>(random >> 24);
    }
    writer.Write(channel, message, noise);
  }
  EXPECT_TRUE(writer.failed());
  EXPECT_EQ(writer.Close(), "No space left on device");
}

TEST(McapWriter, SaysSoAtTheEndIfLittleWasWritten) {
  McapWriter writer;
  ASSERT_EQ(writer.Open("/dev/full", ""), "");
  EXPECT_EQ(writer.Close(), "No space left on device");
}

TEST(McapWriter, CountsBytesAndMessages) {
  const auto path = TestFolder() / "a.mcap";
  McapWriter writer;
  ASSERT_EQ(writer.Open(path, ""), "");
  const std::uint16_t channel = writer.AddChannel(writer.AddSchema("a", "", ""), "/a", "");
  const std::uint16_t other = writer.AddChannel(1, "/b", "");
  writer.Write(channel, 1, "x");
  writer.Write(channel, 2, "y");
  EXPECT_EQ(writer.messages(channel), 2U);
  EXPECT_EQ(writer.messages(other), 0U);
  ASSERT_EQ(writer.Close(), "");
  EXPECT_EQ(writer.bytes(), ReadFile(path).size());
}

}  // namespace
}  // namespace pipewright::hil
