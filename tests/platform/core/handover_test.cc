// SPDX-License-Identifier: MIT
#include "platform/core/handover.h"

#include <gtest/gtest.h>

#include <thread>

namespace pipewright {
namespace {

TEST(Handover, GivesBackInOrderAndThenNothing) {
  Handover<int, 3> queue;
  EXPECT_EQ(queue.Front(), nullptr);
  EXPECT_TRUE(queue.Push(1));
  EXPECT_TRUE(queue.Push(2));
  ASSERT_NE(queue.Front(), nullptr);
  EXPECT_EQ(*queue.Front(), 1);
  queue.Pop();
  EXPECT_EQ(*queue.Front(), 2);
  queue.Pop();
  EXPECT_EQ(queue.Front(), nullptr);
}

TEST(Handover, WhatComesWhileItIsFullIsDroppedAndCounted) {
  Handover<int, 2> queue;
  EXPECT_TRUE(queue.Push(1));
  EXPECT_TRUE(queue.Push(2));
  EXPECT_FALSE(queue.Push(3));
  EXPECT_EQ(queue.dropped(), 1U);
  queue.Pop();
  EXPECT_TRUE(queue.Push(4));
  EXPECT_EQ(*queue.Front(), 2);
  queue.Pop();
  EXPECT_EQ(*queue.Front(), 4);
}

TEST(Handover, BetweenTwoThreadsNothingIsTornLostOrTurnedAround) {
  struct Pair {
    int a = 0;
    int b = 0;
  };
  constexpr int kCount = 2000;
  Handover<Pair, 7> queue;
  std::thread writer([&queue] {
    for (int i = 1; i <= kCount; ++i) {
      while (!queue.Push({i, -i})) {
        std::this_thread::yield();
      }
    }
  });
  for (int i = 1; i <= kCount; ++i) {
    while (queue.Front() == nullptr) {
      std::this_thread::yield();
    }
    EXPECT_EQ(queue.Front()->a, i);
    EXPECT_EQ(queue.Front()->b, -i);
    queue.Pop();
  }
  writer.join();
}

}  // namespace
}  // namespace pipewright
