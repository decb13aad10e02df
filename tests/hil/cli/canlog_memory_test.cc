// SPDX-License-Identifier: MIT
// Memory does not grow with the length of a log: past its first frames nothing is allocated.
#include "hil/canlog/log_reader.h"
#include "hil/canlog/log_stats.h"
#include "hil/canlog/log_watch.h"
#include "tests/support/can_logs.h"
#include "tests/support/no_alloc_scope.h"

namespace pipewright::hil {
namespace {

using namespace test;

TEST(CanlogMemory, DoesNotGrowWithTheLog) {
  const std::vector<LogFrame> frames = RandomFrames(20000, 14);
  for (const NamedLog& log : InEveryFormat(frames)) {
    for (const std::string& bytes : {log.bytes, Gz(log.bytes), Zstd(log.bytes)}) {
      SCOPED_TRACE(log.name);
      ChannelNames channels;
      LogReader reader(channels);
      std::FILE* const file = fmemopen(const_cast<char*>(bytes.data()), bytes.size(), "rb");
      ASSERT_EQ(reader.Open(file, log.name, {}), "");
      LogStats stats(/*count_bits=*/true);
      std::uint64_t found = 0;
      LogWatch watch({}, [&found](const Finding&) { ++found; });
      std::uint64_t read = 0;
      const auto take = [&](std::span<const LogFrame> block) {
        stats.Add(block);
        watch.Add(block);
        read += block.size();
      };
      for (int i = 0; i < 4; ++i) {
        take(reader.Next());  // all ids are in it
      }
      {
        const NoAllocScope no_alloc;
        for (auto block = reader.Next(); !block.empty(); block = reader.Next()) {
          take(block);
        }
      }
      EXPECT_EQ(read, frames.size());
    }
  }
}

}  // namespace
}  // namespace pipewright::hil
