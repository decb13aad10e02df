// SPDX-License-Identifier: MIT
#include "tests/timing/qp_spy.h"

#include "ctrl/constraints/row.h"
#include "ctrl/qp/dual_active_set.h"
#include "ctrl/whole_body/chance_qp.h"

namespace pipewright::timing {
namespace {

using Solver = QpSolver<kControls, kMaxRows>;
using Problem = QpProblem<kControls, kMaxRows>;
using Solution = QpSolution<kControls, kMaxRows>;

const InstructionCount* counter = nullptr;
std::vector<QpSpy::Solve> solves;
std::uint64_t chance_instructions = 0;

std::uint64_t Now() { return counter == nullptr ? 0 : counter->Now(); }

}  // namespace

// A member function is called as a function whose first argument is the object.
const Solution* RealSolve(Solver* solver, const Problem* qp,
                          const Controls* feasible) asm("__real_" PIPEWRIGHT_QP_SOLVE);
const Solution* SpiedSolve(Solver* solver, const Problem* qp,
                           const Controls* feasible) asm("__wrap_" PIPEWRIGHT_QP_SOLVE);

const Solution* SpiedSolve(Solver* solver, const Problem* qp, const Controls* feasible) {
  const std::uint64_t before = Now();
  const Solution* const solution = RealSolve(solver, qp, feasible);
  const std::uint64_t after = Now();
  const auto active = (solution->lambda_rows.head(qp->rows).array() != 0).count() +
                      (solution->lambda_box.array() != 0).count();
  solves.push_back({qp->rows, solution->iterations, static_cast<int>(active), after - before});
  return solution;
}

ChanceQp::Answer RealChance(ChanceQp* qp, const QuadraticCost& cost, const ConstraintSet& set,
                            SvfiMode mode,
                            const Controls& u0) asm("__real_" PIPEWRIGHT_CHANCE_SOLVE);
ChanceQp::Answer SpiedChance(ChanceQp* qp, const QuadraticCost& cost, const ConstraintSet& set,
                             SvfiMode mode,
                             const Controls& u0) asm("__wrap_" PIPEWRIGHT_CHANCE_SOLVE);

ChanceQp::Answer SpiedChance(ChanceQp* qp, const QuadraticCost& cost, const ConstraintSet& set,
                             SvfiMode mode, const Controls& u0) {
  const std::uint64_t before = Now();
  ChanceQp::Answer answer = RealChance(qp, cost, set, mode, u0);
  chance_instructions += Now() - before;
  return answer;
}

void QpSpy::Use(const InstructionCount& instructions) {
  counter = &instructions;
  solves.reserve(1024);
}

void QpSpy::Forget() {
  solves.clear();
  chance_instructions = 0;
}

const std::vector<QpSpy::Solve>& QpSpy::Solves() { return solves; }

std::uint64_t QpSpy::ChanceInstructions() { return chance_instructions; }

}  // namespace pipewright::timing
