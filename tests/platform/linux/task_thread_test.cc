// SPDX-License-Identifier: MIT
#include "platform/linux/task_thread.h"

#include <gtest/gtest.h>

#include <thread>

namespace pipewright {
namespace {

struct Seen {
  std::thread::id thread;
  int runs = 0;
};

void Look(void* context) {
  auto* seen = static_cast<Seen*>(context);
  seen->thread = std::this_thread::get_id();
  ++seen->runs;
}

TEST(TaskThread, RunsItsWorkOnceOnAThreadOfItsOwn) {
  Seen seen;
  TaskThread thread;
  ASSERT_EQ(thread.Start("a name of more than fifteen characters", Look, &seen), Status::kOk);
  EXPECT_TRUE(thread.started());
  thread.Join();
  EXPECT_FALSE(thread.started());
  EXPECT_EQ(seen.runs, 1);
  EXPECT_NE(seen.thread, std::this_thread::get_id());
}

TEST(TaskThread, RefusesASecondWorkUntilTheFirstIsJoined) {
  Seen seen;
  TaskThread thread;
  ASSERT_EQ(thread.Start("first", Look, &seen), Status::kOk);
  EXPECT_EQ(thread.Start("second", Look, &seen), Status::kFull);
  thread.Join();
  EXPECT_EQ(thread.Start("second", Look, &seen), Status::kOk);
  thread.Join();
  EXPECT_EQ(seen.runs, 2);
}

TEST(TaskThread, IsJoinedWhenItGoesOutOfScope) {
  Seen seen;
  {
    TaskThread thread;
    ASSERT_EQ(thread.Start("short", Look, &seen), Status::kOk);
  }
  EXPECT_EQ(seen.runs, 1);
}

TEST(TaskThread, NothingToJoinIsNoWait) {
  TaskThread thread;
  thread.Join();
  EXPECT_FALSE(thread.started());
}

}  // namespace
}  // namespace pipewright
