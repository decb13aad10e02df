// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "hil/canlog/log_reader.h"
#include "tests/support/can_logs.h"
#include "tests/support/command.h"

namespace pipewright::hil::test {

using namespace pipewright::test;

struct ReadLog {
  std::string open_error;
  std::string format;
  std::vector<LogFrame> frames;
  std::vector<std::string> channels;
  LogProblems problems;
};

/// Reads `bytes` as it would a file.
inline ReadLog Read(const std::string& bytes, const LogOptions& options = {}) {
  ReadLog log;
  ChannelNames channels;
  LogReader reader(channels);
  // const_cast: opened for reading only
  std::FILE* const file = fmemopen(const_cast<char*>(bytes.data()), bytes.size(), "rb");
  log.open_error = reader.Open(file, "a.log", options);
  if (log.open_error.empty()) {
    log.format = reader.format();
    for (auto block = reader.Next(); !block.empty(); block = reader.Next()) {
      log.frames.insert(log.frames.end(), block.begin(), block.end());
    }
  }
  log.problems = reader.problems();
  for (int i = 0; i < channels.size(); ++i) {
    log.channels.emplace_back(channels.Name(i));
  }
  return log;
}

/// The first `count` of `expected`, stamps included.
inline void ExpectFrames(const std::vector<LogFrame>& got, const std::vector<LogFrame>& expected,
                         std::size_t count) {
  ASSERT_EQ(got.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    SCOPED_TRACE(testing::Message() << "frame " << i);
    EXPECT_TRUE(SameOnTheWire(got[i], expected[i]));
    EXPECT_EQ(got[i].id, expected[i].id);
    EXPECT_EQ(int{got[i].length}, int{expected[i].length});
    EXPECT_EQ(got[i].stamp_ns, expected[i].stamp_ns);
    EXPECT_TRUE(got[i].stamped);
  }
}

}  // namespace pipewright::hil::test
