// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <chrono>

#include "ctrl/qp/dual_active_set_inl.h"
#include "hil/cli/heap_watch.h"
#include "hil/cli/qp_sizes.h"
#include "hil/cli/qp_without_slacks.h"

// Each size is instantiated in a file of its own: the solver is the slowest thing here to compile.
namespace pipewright::hil {

template <int n, int m>
class SizedQpOf final : public SizedQp {
 public:
  int variables() const override { return n; }
  int rows() const override { return m; }
  void Forget() override { solver_.ForgetActiveSet(); }

  QpMeasured Solve(const QpbProblem& p) override {
    const bool fits = WithoutSlacks(p, qp_);
    assert(fits);
    (void)fits;
    using Clock = std::chrono::steady_clock;
    const HeapWatch heap;
    const Clock::time_point begin = Clock::now();
    solution_ = &solver_.Solve(qp_);
    const Clock::time_point end = Clock::now();
    const std::chrono::duration<double, std::micro> took = end - begin;
    return {solution_->status, solution_->iterations, took.count(), heap.allocations()};
  }

  QpbPoint Point(const QpbProblem& p) const override { return WithSlacks(p, qp_, *solution_); }

 private:
  QpProblem<n, m> qp_;
  QpSolver<n, m> solver_;
  const QpSolution<n, m>* solution_ = nullptr;
};

}  // namespace pipewright::hil
