// SPDX-License-Identifier: MIT
#include "platform/core/fixed_vector.h"

#include <gtest/gtest.h>

namespace pipewright {
namespace {

TEST(FixedVector, RefusesWhatExceedsItsCapacityAndKeepsTheRest) {
  FixedVector<int, 2> v;
  EXPECT_TRUE(v.push_back(1));
  EXPECT_TRUE(v.push_back(2));
  EXPECT_FALSE(v.push_back(3));
  EXPECT_TRUE(v.full());
  EXPECT_EQ(v.size(), 2);
  EXPECT_EQ(v[0], 1);
  EXPECT_EQ(v.back(), 2);
}

TEST(FixedVector, IsEmptyAfterClearAndAfterPoppingAll) {
  FixedVector<int, 2> v;
  ASSERT_TRUE(v.push_back(1));
  v.pop_back();
  EXPECT_TRUE(v.empty());
  ASSERT_TRUE(v.push_back(1));
  v.clear();
  EXPECT_EQ(v.begin(), v.end());
}

}  // namespace
}  // namespace pipewright
