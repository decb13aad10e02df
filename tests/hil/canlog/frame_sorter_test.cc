// SPDX-License-Identifier: MIT
#include "hil/canlog/frame_sorter.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/can_logs.h"

namespace pipewright::hil {
namespace {

using namespace test;

std::vector<std::int64_t> Sorted(const std::vector<std::int64_t>& stamps) {
  std::vector<std::int64_t> out;
  FrameSorter sorter;
  const auto use = [&out](const LogFrame& frame) { out.push_back(frame.stamp_ns); };
  for (const std::int64_t stamp : stamps) {
    sorter.Add(DataFrame(1, {}, stamp), use);
  }
  sorter.End(use);
  return out;
}

TEST(FrameSorter, PutsFramesInOrderThatAreOutOfItByLessThanItsRoom) {
  Rng rng(13);
  std::vector<std::int64_t> stamps;
  for (int i = 0; i < 20000; ++i) {
    stamps.push_back(10 * i - rng.Index(10 * 1000));
  }
  const std::vector<std::int64_t> sorted = Sorted(stamps);
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));
  std::sort(stamps.begin(), stamps.end());
  EXPECT_EQ(sorted, stamps);
}

TEST(FrameSorter, LosesNoneThatComeTooLate) {
  std::vector<std::int64_t> stamps;
  for (int i = 0; i < 10000; ++i) {
    stamps.push_back(i);
  }
  stamps.push_back(-1);
  std::vector<std::int64_t> sorted = Sorted(stamps);
  EXPECT_FALSE(std::is_sorted(sorted.begin(), sorted.end()));
  std::sort(sorted.begin(), sorted.end());
  std::sort(stamps.begin(), stamps.end());
  EXPECT_EQ(sorted, stamps);
}

TEST(FrameSorter, KeepsTheOrderOfTheLogAtOneTime) {
  FrameSorter sorter;
  std::vector<std::uint32_t> ids;
  const auto use = [&ids](const LogFrame& frame) { ids.push_back(frame.id); };
  for (std::uint32_t id = 0; id < 100; ++id) {
    sorter.Add(DataFrame(id, {}, 5), use);
  }
  sorter.End(use);
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
  EXPECT_EQ(ids.size(), 100U);
}

}  // namespace
}  // namespace pipewright::hil
