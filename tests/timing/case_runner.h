// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ctrl/whole_body/whole_body_controller.h"
#include "tests/plan/motion/cell.h"
#include "tests/timing/cycle_case.h"
#include "tests/timing/instruction_count.h"
#include "tests/timing/qp_spy.h"

namespace pipewright::timing {

/// What the costliest cycle of a case did, and what went wrong in any.
struct CycleCost {
  std::uint64_t instructions = 0;  ///< of law and envelope; 0 when nothing counts
  std::uint64_t in_chance = 0;     ///< of them, within ChanceQp::Solve
  std::uint64_t in_solver = 0;     ///< and of these within QpSolver::Solve
  ControlStats stats;
  double work = 0;  ///< of the solver, by its iterations and active sets
  std::vector<QpSpy::Solve> solves;
  int iterations_max = 0;  ///< of one QP
  std::string trouble;     ///< the first thing that went wrong; empty: nothing
};

/// Runs cases on a controller of their own, fresh each time.
class CaseRunner {
 public:
  explicit CaseRunner(const InstructionCount& instructions);

  /// One entry a cycle. Empty: the case's law is not valid.
  const std::vector<CycleCost>& Run(const CycleCase& c);

 private:
  void BuildFields(const CycleCase& c);

  const InstructionCount& instructions_;
  std::unique_ptr<test::Cell> cell_;
  std::vector<CaseBox> boxes_;  ///< that are in it
  test::Cell free_;
  std::vector<CycleCost> cycles_;
};

}  // namespace pipewright::timing
