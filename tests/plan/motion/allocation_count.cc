// SPDX-License-Identifier: MIT
#include "tests/plan/motion/allocation_count.h"

#include <cstdlib>
#include <new>

namespace {
long allocations = 0;
}  // namespace

// Away from the tests, so that no compiler pairs these with its own.
void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) {
    return memory;
  }
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace pipewright::test {

long AllocationCount() { return allocations; }

}  // namespace pipewright::test
