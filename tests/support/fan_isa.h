// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include "perception/map/fan_kernels.h"

namespace pipewright::test {

/// Runs a test with AVX2, where the machine has it, and without.
class FanIsa : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    const bool baseline_only = GetParam();
    if (fan::UseBaseline(baseline_only) == baseline_only) {
      GTEST_SKIP() << "SKIPPED: this machine has no AVX2";
    }
  }
  void TearDown() override { fan::UseBaseline(false); }

 public:
  static const char* Of(const testing::TestParamInfo<bool>& isa) {
    return isa.param ? "baseline" : "avx2";
  }
};

}  // namespace pipewright::test
