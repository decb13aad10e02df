// SPDX-License-Identifier: MIT
#pragma once

namespace pipewright::test {

/// Calls of operator new in this test binary so far.
long AllocationCount();

}  // namespace pipewright::test
