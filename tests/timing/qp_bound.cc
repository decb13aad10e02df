// SPDX-License-Identifier: MIT
#include "tests/timing/qp_bound.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "ctrl/constraints/row.h"
#include "ctrl/qp/dual_active_set.h"
#include "platform/core/rng.h"
#include "tests/timing/qp_spy.h"

namespace pipewright::timing {
namespace {

using Problem = QpProblem<kControls, kMaxRows>;
using Solver = QpSolver<kControls, kMaxRows>;

constexpr int kPulling = 64;  ///< soft rows that no x can please
constexpr double kPrice = 5e3;
constexpr int kEnough = 1000;      ///< iterations
constexpr int kFewIterations = 3;  ///< of a warm solve: it is what lies around them

Vec<kControls> Random(Rng& rng) {
  Vec<kControls> v;
  for (double& x : v) {
    x = rng.Normal();
  }
  return v;
}

/// All rows taken: kPulling soft ones that pull further than the box allows, the other hard ones
/// loose or just touched. By kind: rows of their own, rows that nearly repeat a few, and both with
/// a cost that is a hundred times as steep along some axes.
std::unique_ptr<Problem> Force(int kind, Rng& rng) {
  auto qp = std::make_unique<Problem>();
  for (int j = 0; j < kControls; ++j) {
    qp->H(j, j) = kind < 2 || j % 2 == 0 ? 2.4 : 240;
  }
  const Vec<kControls> along = Random(rng);
  qp->H += along * along.transpose();
  qp->g = 10 * Random(rng);
  qp->lb.setConstant(-1);
  qp->ub.setConstant(1);
  Vec<kControls> few[3] = {Random(rng), Random(rng), Random(rng)};
  for (int i = 0; i < kMaxRows; ++i) {
    const bool pulls = i % 3 == 0 && i / 3 < kPulling;
    Vec<kControls> a = Random(rng);
    if (kind % 2 == 1) {
      a = few[i % 3] + 1e-5 * a;
    }
    const double hi = pulls ? rng.Uniform(-9, 0.5) : rng.Uniform(0, 1);
    static_cast<void>(qp->AddRow(a, -kInfinity, hi, pulls ? kPrice : 0, i + 1));
  }
  return qp;
}

/// The same problem with its rows in reverse: each is found by its key only.
std::unique_ptr<Problem> Reversed(const Problem& qp) {
  auto other = std::make_unique<Problem>(qp);
  other->ClearRows();
  for (int i = qp.rows - 1; i >= 0; --i) {
    static_cast<void>(
        other->AddRow(qp.A.row(i).transpose(), qp.lo[i], qp.hi[i], qp.price[i], qp.key[i]));
  }
  return other;
}

/// What the spy saw of one solve: instructions of the solver alone.
QpSpy::Solve Count(Solver& solver, const Problem& qp) {
  const Controls feasible = Controls::Zero();
  QpSpy::Forget();
  solver.Solve(qp, &feasible);
  return QpSpy::Solves().back();
}

/// One more iteration each time, from none remembered, until the cap is no more what ends it.
void MeasureIterations(const Problem& qp, int iterations, std::vector<std::uint64_t>& costs) {
  std::uint64_t last = 0;
  for (int cap = 1; cap <= iterations; ++cap) {
    const auto solver = std::make_unique<Solver>(QpConfig{.max_iterations = cap});
    const std::uint64_t now = Count(*solver, qp).instructions;
    if (cap > 1 && now > last) {
      costs.push_back(now - last);
    }
    last = now;
  }
}

}  // namespace

QpCost MeasureQp(int problems, std::uint64_t seed) {
  QpCost cost;
  std::vector<std::uint64_t> iterations;
  Rng rng(seed);
  for (int p = 0; p < problems; ++p) {
    const auto qp = Force(p % 4, rng);
    const auto reversed = Reversed(*qp);
    const auto solver = std::make_unique<Solver>(QpConfig{.max_iterations = kEnough});
    const QpSpy::Solve cold = Count(*solver, *qp);
    const QpSpy::Solve warm = Count(*solver, *reversed);
    cost.active_max = std::max(cost.active_max, cold.active);
    cost.iterations_max = std::max(cost.iterations_max, cold.iterations);
    if (warm.iterations <= kFewIterations) {
      cost.around = std::max(cost.around, warm.instructions);
    }
    MeasureIterations(*qp, cold.iterations, iterations);
  }
  std::sort(iterations.begin(), iterations.end());
  if (!iterations.empty()) {
    cost.iteration = iterations.back();
    cost.iteration_median = iterations[iterations.size() / 2];
  }
  return cost;
}

}  // namespace pipewright::timing
