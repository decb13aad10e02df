// SPDX-License-Identifier: MIT
#include "platform/core/time.h"

#include <gtest/gtest.h>

#include <string_view>

#include "platform/core/status.h"

namespace pipewright {
namespace {

using std::chrono_literals::operator""ms;

TEST(Time, SecondsAndDurationsConvertBothWays) {
  EXPECT_EQ(FromSeconds(0.02), 20ms);
  EXPECT_EQ(FromSeconds(-0.02), -20ms);
  EXPECT_EQ(ToSeconds(20ms), 0.02);
  EXPECT_EQ(ToSeconds(Time{1500ms}), 1.5);
}

TEST(Status, EveryStatusHasItsOwnName) {
  for (int i = 0; i <= static_cast<int>(Status::kFault); ++i) {
    for (int j = 0; j < i; ++j) {
      EXPECT_NE(std::string_view(Name(static_cast<Status>(i))), Name(static_cast<Status>(j)));
    }
  }
}

TEST(Result, HoldsAValueOrTheReasonThereIsNone) {
  const Result<int> value = 3;
  const Result<int> none = Status::kStale;
  EXPECT_TRUE(value.ok());
  EXPECT_EQ(*value, 3);
  EXPECT_FALSE(none.ok());
  EXPECT_EQ(none.status(), Status::kStale);
}

}  // namespace
}  // namespace pipewright
