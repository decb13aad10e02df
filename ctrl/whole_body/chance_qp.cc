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
    cone_[i] = i - first_chance_;
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

const Vec<kMaxRows>& ChanceQp::SolveOnce(Answer& answer) {
  const Controls zero = Controls::Zero();
  const auto& solution = solver_.Solve(qp_, &zero);
  ++answer.stats.rounds;
  answer.stats.iterations += solution.iterations;
  if (solution.status != QpStatus::kOptimal) {
    answer.stats.status = solution.status;
  }
  const bool usable = solution.status == QpStatus::kOptimal ||
                      (solution.status == QpStatus::kCapped && solution.hard_feasible);
  // The box is exact: what the solver's tolerance leaves outside it is cut off.
  answer.u = usable ? Controls(solution.x.cwiseMax(qp_.lb).cwiseMin(qp_.ub)) : zero;
  return solution.lambda_rows;
}

/// Whether u meets every cone. Soft ones: with the slack that was paid for.
bool ChanceQp::Meets(const ConstraintSet& set, const Controls& u) const {
  int i = first_chance_;
  for (const ChanceRow& row : set.chance) {
    const double slack = row.price > 0 ? std::max(qp_.A.row(i).dot(u) - qp_.hi[i], 0.0) : 0;
    if (ChanceExcess(row, u, set.z) > slack + kConeTolerance_mps) {
      return false;
    }
    ++i;
  }
  return true;
}

/// Poses the next QP about u: tangents there, and the curvature of the cones that the last answer
/// leans on in the cost. When the rows are full, a hard cone's first tangent gives way.
void ChanceQp::PoseAbout(const QuadraticCost& cost, const ConstraintSet& set, const Controls& u,
                         const Vec<kMaxRows>& lambda) {
  qp_.H = cost.H;
  qp_.g = cost.g;
  const int rows = qp_.rows;
  for (int k = 0; k < set.chance.size(); ++k) {
    const ChanceRow& row = set.chance[k];
    double weight = 0;  // of all its cuts
    for (int i = first_chance_; i < rows; ++i) {
      weight += cone_[i] == k ? lambda[i] : 0;
    }
    const bool unmet = ChanceExcess(row, u, set.z) > 0;
    if (unmet || weight > 0) {
      const bool append = row.price == 0 && qp_.rows < kMaxRows;
      const int i = append ? qp_.rows++ : first_chance_ + k;
      SetRow(i, TangentCut(row, u, set.z));
      cone_[i] = k;
    }
    if (weight > 0) {
      const Mat<3, kControls> bent = row.cone.Curvature(row.J * u).lazyProduct(row.J);
      const Mat<kControls, kControls> C = weight * set.z * row.J.transpose().lazyProduct(bent);
      qp_.H += C;
      qp_.g -= C * u;
    }
  }
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
  const Vec<kMaxRows>* lambda = &SolveOnce(answer);
  if (mode == SvfiMode::kExact) {
    bool met = Meets(set, answer.u);
    while (!met && answer.stats.rounds < max_rounds_) {
      const Controls last = answer.u;
      PoseAbout(cost, set, last, *lambda);
      lambda = &SolveOnce(answer);
      met =
          Meets(set, answer.u) && (answer.u - last).squaredNorm() < kStepTolerance * kStepTolerance;
    }
    answer.stats.fallbacks = met ? 0 : FallBack(set, answer.u);
    if (answer.stats.fallbacks > 0) {
      qp_.H = cost.H;
      qp_.g = cost.g;
      SolveOnce(answer);
    }
  }
  if (mode != SvfiMode::kPreviousVelocity) {  // that mode is as published: it may under-estimate
    Shorten(set, answer);
  }
  Count(set, answer.u, answer.stats);
  return answer;
}

}  // namespace pipewright
