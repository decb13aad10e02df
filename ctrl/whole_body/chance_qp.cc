// SPDX-License-Identifier: MIT
#include "ctrl/whole_body/chance_qp.h"

#include <algorithm>

namespace pipewright {
namespace {

/// Largest t in [0, 1] at which t u keeps the row, by bisection of a convex function that is ≤ 0
/// at 0.
double LargestScale(const ChanceRow& row, const Controls& u, double z) {
  double lo = 0;
  double hi = 1;
  for (int i = 0; i < 40; ++i) {
    const double middle = (lo + hi) / 2;
    (ChanceExcess(row, middle * u, z) <= 0 ? lo : hi) = middle;
  }
  return lo;
}

void Shorten(const ConstraintSet& set, ChanceQp::Answer& answer) {
  double scale = 1;
  for (const ChanceRow& row : set.chance) {
    if (row.price == 0 && ChanceExcess(row, answer.u, set.z) > ChanceQp::kConeTolerance_mps) {
      scale = std::min(scale, LargestScale(row, answer.u, set.z));
    }
  }
  answer.stats.scale = scale;
  answer.u *= scale;
}

void Count(const ConstraintSet& set, const Controls& u, ChanceQpStats& stats) {
  for (const ChanceRow& row : set.chance) {
    const bool held =
        ChanceExcess(row, u, set.z) + row.limit <= row.b + ChanceQp::kConeTolerance_mps;
    const bool hard = row.price == 0;
    ++(hard ? stats.checked : stats.soft_checked);
    (hard ? stats.held : stats.soft_held) += held ? 1 : 0;
  }
}

}  // namespace

void ChanceQp::SetRow(int i, const Row& row) {
  qp_.A.row(i) = row.a.transpose();
  qp_.lo[i] = row.lo;
  qp_.hi[i] = row.hi;
  qp_.price[i] = row.price;
  qp_.key[i] = row.key;
}

void ChanceQp::Pose(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
                    const Controls& u0) {
  qp_.H = cost.H;
  qp_.g = cost.g;
  qp_.lb = set.lb;
  qp_.ub = set.ub;
  int i = 0;
  for (const Row& row : set.rows) {
    SetRow(i++, row);
  }
  first_chance_ = i;
  for (const ChanceRow& row : set.chance) {
    switch (mode) {
      case SvfiMode::kExact:
        SetRow(i++, TangentCut(row, u0, set.z));
        break;
      case SvfiMode::kPreviousVelocity:
        SetRow(i++, FrozenRow(row, u0, set.z));
        break;
      case SvfiMode::kWorstCase:
        SetRow(i++, WorstCaseRow(row, set.lb, set.ub, set.z));
        break;
    }
  }
  qp_.rows = i;
}

void ChanceQp::SolveOnce(Answer& answer) {
  const Controls zero = Controls::Zero();
  const auto& solution = solver_.Solve(qp_, &zero);
  ++answer.stats.rounds;
  answer.stats.iterations += solution.iterations;
  if (solution.status != QpStatus::kOptimal) {
    answer.stats.status = solution.status;
  }
  const bool usable = solution.status == QpStatus::kOptimal ||
                      (solution.status == QpStatus::kCapped && solution.hard_feasible);
  answer.u = usable ? solution.x : zero;
}

/// Puts the tangents of the cones that u does not meet at u. How many.
int ChanceQp::Recut(const ConstraintSet& set, const Controls& u) {
  int unmet = 0;
  int i = first_chance_;
  for (const ChanceRow& row : set.chance) {
    const double excess = ChanceExcess(row, u, set.z);
    const double cut_excess = std::max(qp_.A.row(i).dot(u) - qp_.hi[i], 0.0);
    const double allowed = row.price > 0 ? cut_excess : 0;  // a soft row: what its slack paid for
    if (excess > allowed + kConeTolerance_mps) {
      SetRow(i, TangentCut(row, u, set.z));
      ++unmet;
    }
    ++i;
  }
  return unmet;
}

int ChanceQp::FallBack(const ConstraintSet& set, const Controls& u) {
  int count = 0;
  int i = first_chance_;
  for (const ChanceRow& row : set.chance) {
    if (row.price == 0 && ChanceExcess(row, u, set.z) > kConeTolerance_mps) {
      SetRow(i, WorstCaseRow(row, set.lb, set.ub, set.z));
      ++count;
    }
    ++i;
  }
  return count;
}

ChanceQp::Answer ChanceQp::Solve(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
                                 const Controls& u0) {
  Answer answer;
  Pose(cost, set, mode, u0);
  SolveOnce(answer);
  if (mode == SvfiMode::kExact) {
    bool met = Recut(set, answer.u) == 0;
    while (!met && answer.stats.rounds < max_rounds_) {
      SolveOnce(answer);
      met = Recut(set, answer.u) == 0;
    }
    if (!met) {
      answer.stats.fallbacks = FallBack(set, answer.u);
      if (answer.stats.fallbacks > 0) {
        SolveOnce(answer);
      }
    }
  }
  if (mode != SvfiMode::kPreviousVelocity) {  // that mode is as published: it may under-estimate
    Shorten(set, answer);
  }
  Count(set, answer.u, answer.stats);
  return answer;
}

}  // namespace pipewright
