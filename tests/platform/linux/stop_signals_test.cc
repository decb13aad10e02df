// SPDX-License-Identifier: MIT
#include "platform/linux/stop_signals.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

namespace pipewright {
namespace {

TEST(StopSignals, AreAskedForAndInterruptNothing) {
  StopSignals::Block();
  EXPECT_FALSE(StopSignals::Pending());
  for (const int signal : {SIGTERM, SIGINT}) {
    ASSERT_EQ(kill(getpid(), signal), 0);
    EXPECT_TRUE(StopSignals::Pending());
    EXPECT_FALSE(StopSignals::Pending());
  }
}

}  // namespace
}  // namespace pipewright
