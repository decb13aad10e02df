// SPDX-License-Identifier: MIT
#include "platform/linux/latch_file.h"

#include <gtest/gtest.h>

#include "tests/support/command.h"

namespace pipewright {
namespace {

TEST(LatchFile, KeepsAReasonForTheNextProcess) {
  const std::string path = test::TestFolder() / "latch";
  const LatchFile latch(path);
  EXPECT_EQ(latch.Read(), "");
  EXPECT_EQ(latch.Set("a run was under way"), Status::kOk);
  EXPECT_EQ(LatchFile(path).Read(), "a run was under way");
  EXPECT_EQ(latch.Set("emergency stop"), Status::kOk);
  EXPECT_EQ(LatchFile(path).Read(), "emergency stop");
  EXPECT_EQ(latch.Clear(), Status::kOk);
  EXPECT_EQ(latch.Clear(), Status::kOk);
  EXPECT_EQ(LatchFile(path).Read(), "");
}

TEST(LatchFile, WhateverIsInItLatchesAndIsPlain) {
  const std::filesystem::path folder = test::TestFolder();
  for (const std::string& bytes :
       {std::string(), std::string("\0\x01\"\\", 4), std::string(5000, 'x')}) {
    test::WriteFile(folder / "latch", bytes);
    const std::string reason = LatchFile(folder / "latch").Read();
    EXPECT_FALSE(reason.empty());
    EXPECT_LE(reason.size(), 200U);
    EXPECT_EQ(reason.find_first_of("\"\\"), std::string::npos);
  }
  EXPECT_FALSE(LatchFile(folder).Read().empty());  // a folder: cannot be read
}

TEST(LatchFile, WhatCannotBeWrittenIsTold) {
  const LatchFile latch("/nowhere/latch");
  EXPECT_EQ(latch.Read(), "");
  EXPECT_EQ(latch.Set("x"), Status::kUnavailable);
  const LatchFile none;
  EXPECT_FALSE(none.kept());
  EXPECT_EQ(none.Set("x"), Status::kOk);
  EXPECT_EQ(none.Read(), "");
}

}  // namespace
}  // namespace pipewright
