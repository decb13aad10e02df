// SPDX-License-Identifier: MIT
#include "tests/timing/case_runner.h"

#include <algorithm>

#include "ctrl/envelope/envelope.h"
#include "ctrl/robot_program/control_task.h"
#include "platform/robot/shapes.h"

namespace pipewright::timing {
namespace {

constexpr double kRowTolerance = 1e-9;  ///< m/s; the solver's own is 1e-10

bool Same(const std::vector<CaseBox>& a, const std::vector<CaseBox>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.lo_W == y.lo_W && x.hi_W == y.hi_W;
  });
}

/// About the instructions of a solve that ended with `active` rows, begun perhaps with as many:
/// k^2 multiply-adds for each that comes or goes.
double Work(const QpSpy::Solve& solve) {
  constexpr double kMany = 70;
  const double k = solve.active < 0 ? kMany : solve.active;
  return (solve.iterations + k / 2 + 1) * (2000 + 60 * k + 3 * k * k);
}

/// What of the law's promises this answer breaks; empty: none.
std::string Trouble(const ControlOutput& output, const ConstraintSet& set) {
  const ChanceQpStats& qp = output.stats.qp;
  const bool many = qp.iterations > ChanceQp::kMaxIterations;
  const Controls& u = output.u;
  if (!u.allFinite()) {
    return "not-finite";
  }
  if ((u - set.ub).maxCoeff() > 0 || (set.lb - u).maxCoeff() > 0) {
    return "outside-box";
  }
  for (const Row& row : set.rows) {
    const double y = row.a.dot(u);
    if (row.price == 0 && (y > row.hi + kRowTolerance || y < row.lo - kRowTolerance)) {
      return "hard-row-broken";
    }
  }
  for (const ChanceRow& row : set.chance) {
    if (row.price == 0 && ChanceExcess(row, u, set.z) > ChanceQp::kConeTolerance_mps) {
      return "hard-cone-broken";
    }
  }
  if (qp.status != QpStatus::kOptimal) {
    return qp.status == QpStatus::kCapped       ? (many ? "capped-by-iterations" : "capped-before")
           : qp.status == QpStatus::kInfeasible ? "infeasible"
                                                : "invalid";
  }
  return qp.fallbacks > 0 ? "fallback" : qp.scale < 1 ? "shortened" : "";
}

}  // namespace

CaseRunner::CaseRunner(const InstructionCount& instructions) : instructions_(instructions) {
  QpSpy::Use(instructions);
}

void CaseRunner::BuildFields(const CycleCase& c) {
  if (cell_ != nullptr && Same(c.boxes, boxes_)) {
    return;
  }
  cell_ = std::make_unique<test::Cell>();
  for (const CaseBox& box : c.boxes) {
    cell_->AddBox(box.lo_W, box.hi_W);
  }
  boxes_ = c.boxes;
}

const std::vector<CycleCost>& CaseRunner::Run(const CycleCase& c) {
  BuildFields(c);
  cycles_.clear();
  ControlTaskConfig config;
  config.law.constraints.period_s = c.period_s;
  config.law.constraints.alpha = c.alpha;
  config.law.constraints.joint_risk = c.joint_risk;
  const auto law =
      std::make_unique<WholeBodyController>(config.law, TracerUf7(), TracerUf7Shapes());
  Envelope envelope(EnvelopeOf(TracerUf7(), config));
  if (law->status() != Status::kOk) {
    return cycles_;
  }
  const Scene nothing;
  Time now{};
  for (const CaseStep& step : c.steps) {
    const test::Cell& cell = step.alone ? free_ : *cell_;
    const Surroundings around = cell.around();
    for (int i = 0; i < step.cycles; ++i) {
      now += FromSeconds(c.period_s);
      RobotState state;
      state.stamp = now;
      state.q = step.q;
      state.valid = true;
      const ControlInput input{.state = state,
                               .scene = step.alone ? nothing : c.scene,
                               .field = around.field,
                               .goal = step.goal};
      QpSpy::Forget();
      const std::uint64_t before = instructions_.Now();
      const ControlOutput output = law->Step(input, now);
      static_cast<void>(envelope.Step(output.u, state, now));
      CycleCost cost;
      cost.instructions = instructions_.Now() - before;
      cost.in_chance = QpSpy::ChanceInstructions();
      cost.stats = output.stats;
      cost.solves = QpSpy::Solves();
      for (const QpSpy::Solve& solve : cost.solves) {
        cost.work += Work(solve);
        cost.in_solver += solve.instructions;
        cost.iterations_max = std::max(cost.iterations_max, solve.iterations);
      }
      cost.trouble = Trouble(output, law->constraints());
      if (static_cast<int>(cost.solves.size()) != output.stats.qp.rounds) {
        cost.trouble = "solver-unseen";
      }
      cycles_.push_back(std::move(cost));
    }
  }
  return cycles_;
}

}  // namespace pipewright::timing
