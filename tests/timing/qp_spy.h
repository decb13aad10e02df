// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "tests/timing/instruction_count.h"

namespace pipewright::timing {

/// What the controller's QP solver was asked since Forget(), seen from outside: the linker puts the
/// spy before QpSolver::Solve and ChanceQp::Solve (see CMakeLists.txt).
class QpSpy {
 public:
  struct Solve {
    int rows = 0;
    int iterations = 0;
    int active = 0;  ///< rows and bounds with a multiplier; -1: capped, and none is reported
    std::uint64_t instructions = 0;  ///< 0 when nothing counts
  };

  /// For the whole program; `instructions` must outlive it.
  static void Use(const InstructionCount& instructions);
  static void Forget();
  static const std::vector<Solve>& Solves();
  static std::uint64_t ChanceInstructions();  ///< within ChanceQp::Solve, its QPs included
};

}  // namespace pipewright::timing
