// SPDX-License-Identifier: MIT
#include "platform/core/latest.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace pipewright {
namespace {

TEST(Latest, ReadsADefaultValueBeforeTheFirstIsPublished) {
  Latest<int> latest;
  EXPECT_FALSE(latest.HasNew());
  EXPECT_EQ(latest.Read(), 0);
}

TEST(Latest, ReadsTheNewestOfSeveral) {
  Latest<int> latest;
  latest.Write(1);
  latest.Write(2);
  latest.Write(3);
  EXPECT_TRUE(latest.HasNew());
  EXPECT_EQ(latest.Read(), 3);
  EXPECT_FALSE(latest.HasNew());
  EXPECT_EQ(latest.Read(), 3);
}

TEST(Latest, TheReadersValueDoesNotChangeUnderIt) {
  Latest<int> latest;
  latest.Write(1);
  const int& held = latest.Read();
  latest.Write(2);
  latest.Write(3);
  EXPECT_EQ(held, 1);
}

// Run under the tsan preset this also shows that no slot is ever written and read at once.
TEST(Latest, NeverTearsNorGoesBackBetweenTwoThreads) {
  struct Value {
    std::array<int, 64> words{};
  };
  constexpr int kWrites = 20'000;
  Latest<Value> latest;
  std::thread writer([&] {
    for (int i = 1; i <= kWrites; ++i) {
      latest.Back().words.fill(i);
      latest.Publish();
    }
  });
  int last = 0;
  while (last < kWrites) {
    const Value& value = latest.Read();
    for (const int word : value.words) {
      ASSERT_EQ(word, value.words[0]);
    }
    ASSERT_GE(value.words[0], last);
    last = value.words[0];
  }
  writer.join();
}

}  // namespace
}  // namespace pipewright
