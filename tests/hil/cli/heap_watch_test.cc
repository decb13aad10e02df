// SPDX-License-Identifier: MIT
#include "hil/cli/heap_watch.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <new>
#include <string>
#include <thread>
#include <vector>

namespace pipewright::hil {
namespace {

void* volatile kept = nullptr;

/// So that no allocation is optimised away.
void* Keep(void* p) {
  kept = p;
  return p;
}

struct Way {
  const char* name;
  std::function<void()> take;
};

TEST(HeapWatch, CountsEveryWayToTheHeap) {
  if (!HeapWatch::Counting()) {
    GTEST_SKIP() << "a sanitizer has its own allocator";
  }
  struct alignas(64) Wide {
    char bytes[64];
  };
  const std::vector<Way> ways = {
      {"malloc", [] { free(Keep(malloc(10))); }},
      {"calloc", [] { free(Keep(calloc(3, 10))); }},
      {"realloc", [] { free(Keep(realloc(nullptr, 10))); }},
      {"aligned_alloc", [] { free(Keep(aligned_alloc(64, 128))); }},
      {"posix_memalign",
       [] {
         void* p = nullptr;
         if (posix_memalign(&p, 64, 100) == 0) {
           free(Keep(p));
         }
       }},
      {"new", [] { ::operator delete(Keep(::operator new(10))); }},
      {"aligned new",
       [] {
         void* const p = Keep(::operator new(sizeof(Wide), std::align_val_t(64)));
         ::operator delete(p, std::align_val_t(64));
       }},
      {"a string", [] { Keep(std::string(100, 'x').data()); }},
  };
  for (const Way& way : ways) {
    std::uint64_t counted = 0;
    {
      const HeapWatch watch;
      way.take();
      counted = watch.allocations();
    }
    EXPECT_GE(counted, 1U) << way.name;
  }
}

TEST(HeapWatch, CountsNothingOutsideItsLifeAndNothingOfOtherThreads) {
  if (!HeapWatch::Counting()) {
    GTEST_SKIP() << "a sanitizer has its own allocator";
  }
  ::operator delete(Keep(::operator new(10)));
  std::uint64_t idle = 0;
  {
    const HeapWatch watch;
    double sum = 0;
    for (int i = 1; i < 100; ++i) {
      sum += 1.0 / i;
    }
    ASSERT_GT(sum, 5);
    idle = watch.allocations();
  }
  EXPECT_EQ(idle, 0U);

  std::uint64_t before = 0;
  std::uint64_t after = 0;
  const HeapWatch watch;
  std::thread other([] {
    for (int i = 0; i < 1000; ++i) {
      ::operator delete(Keep(::operator new(10)));
    }
  });
  before = watch.allocations();  // the thread itself took some
  other.join();
  after = watch.allocations();
  EXPECT_EQ(after, before);
}

TEST(HeapWatch, NestsWithoutCountingTwice) {
  if (!HeapWatch::Counting()) {
    GTEST_SKIP() << "a sanitizer has its own allocator";
  }
  const HeapWatch outer;
  std::uint64_t inside = 0;
  {
    const HeapWatch inner;
    free(Keep(malloc(10)));
    inside = inner.allocations();
  }
  free(Keep(malloc(10)));
  const std::uint64_t all = outer.allocations();
  EXPECT_EQ(inside, 1U);
  EXPECT_EQ(all, 2U);
}

}  // namespace
}  // namespace pipewright::hil
