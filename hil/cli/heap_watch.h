// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace pipewright::hil {

/// Counts what this thread takes from the heap while a HeapWatch lives: every malloc, calloc,
/// realloc, aligned allocation and operator new of the process passes here. Under a sanitizer,
/// which has its own allocator, nothing is counted and Counting() is false.
class HeapWatch {
 public:
  HeapWatch();
  ~HeapWatch();
  HeapWatch(const HeapWatch&) = delete;
  HeapWatch& operator=(const HeapWatch&) = delete;

  std::uint64_t allocations() const;
  static bool Counting();

 private:
  std::uint64_t before_;
};

}  // namespace pipewright::hil
