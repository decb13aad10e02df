// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include "hil/cli/heap_watch.h"

namespace pipewright::test {

/// What this thread does while it lives must not take anything from the heap; a failure of the
/// running test otherwise. Under a sanitizer nothing is counted. Link hil_cli.
class NoAllocScope {
 public:
  NoAllocScope() = default;
  ~NoAllocScope() {
    const auto allocations = watch_.allocations();
    EXPECT_EQ(allocations, 0U) << "allocations in a NoAllocScope";
  }
  NoAllocScope(const NoAllocScope&) = delete;
  NoAllocScope& operator=(const NoAllocScope&) = delete;

 private:
  hil::HeapWatch watch_;
};

}  // namespace pipewright::test
