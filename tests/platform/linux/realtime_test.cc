// SPDX-License-Identifier: MIT
#include "platform/linux/realtime.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <thread>

namespace pipewright {
namespace {

// What a machine grants differs; what is claimed must be what the kernel then says.
TEST(Realtime, ClaimsOnlyWhatTheThreadReallyHas) {
  std::thread([] {
    const RealtimeGrant grant = MakeRealtime({.priority = 10, .cpu = 0, .stack_bytes = 64 * 1024});
    int policy = 0;
    sched_param parameters{};
    ASSERT_EQ(pthread_getschedparam(pthread_self(), &policy, &parameters), 0);
    EXPECT_EQ(grant.scheduler_error == 0, policy == SCHED_FIFO);
    if (grant.scheduler_error == 0) {
      EXPECT_EQ(parameters.sched_priority, 10);
    }
    if (grant.affinity_error == 0) {
      EXPECT_EQ(sched_getcpu(), 0);
    }
    EXPECT_EQ(grant.complete(),
              grant.memory_error == 0 && grant.scheduler_error == 0 && grant.affinity_error == 0);
  }).join();
  munlockall();
}

TEST(Realtime, SaysWhatCouldNotBeHad) {
  std::thread([] {
    const RealtimeGrant grant = MakeRealtime({.priority = 1000, .cpu = 1 << 20});
    EXPECT_EQ(grant.scheduler_error, EINVAL);
    EXPECT_EQ(grant.affinity_error, EINVAL);
    EXPECT_FALSE(grant.complete());
  }).join();
  munlockall();
}

}  // namespace
}  // namespace pipewright
