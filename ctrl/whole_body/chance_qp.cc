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
  solver_.LimitIterations(std::max(kMaxIterations - answer.stats.iterations, 1));
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

void ChanceQp::Evaluate(const ConstraintSet& set, const Controls& u) {
  for (int k = 0; k < set.chance.size(); ++k) {
    excess_[k] = ChanceExcess(set.chance[k], u, set.z);
  }
}

/// Whether u, that of the last Evaluate, meets every cone. Soft ones: with the slack paid for.
bool ChanceQp::Meets(const ConstraintSet& set, const Controls& u) const {
  for (int k = 0; k < set.chance.size(); ++k) {
    const int i = first_chance_ + k;
    const bool soft = set.chance[k].price > 0;
    const double slack = soft ? std::max(qp_.A.row(i).dot(u) - qp_.hi[i], 0.0) : 0;
    if (excess_[k] > slack + kConeTolerance_mps) {
      return false;
    }
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
    if (excess_[k] > 0 || weight > 0) {
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

int ChanceQp::FallBack(const ConstraintSet& set) {
  int count = 0;
  for (int k = 0; k < set.chance.size(); ++k) {
    const ChanceRow& row = set.chance[k];
    if (row.price == 0 && excess_[k] > kConeTolerance_mps) {
      SetRow(first_chance_ + k, WorstCaseRow(row, set.lb, set.ub, set.z));
      ++count;
    }
  }
  return count;
}

void ChanceQp::Shorten(const ConstraintSet& set, Answer& answer) {
  double scale = 1;
  for (int k = 0; k < set.chance.size(); ++k) {
    const ChanceRow& row = set.chance[k];
    if (row.price == 0 && excess_[k] > kConeTolerance_mps) {
      scale = std::min(scale, LargestScale(row, answer.u, set.z));
    }
  }
  answer.stats.scale = scale;
  if (scale < 1) {
    answer.u *= scale;
    Evaluate(set, answer.u);
  }
}

void ChanceQp::CountRow(const ChanceRow& row, double excess_mps, ChanceQpStats& stats) {
  const bool held = excess_mps + row.limit <= row.b + kConeTolerance_mps;
  const bool hard = row.price == 0;
  ++(hard ? stats.checked : stats.soft_checked);
  (hard ? stats.held : stats.soft_held) += held ? 1 : 0;
}

void ChanceQp::Count(const ConstraintSet& set, const Controls& u, ChanceQpStats& stats) {
  stats.checked = stats.held = stats.soft_checked = stats.soft_held = 0;
  for (const ChanceRow& row : set.chance) {
    CountRow(row, ChanceExcess(row, u, set.z), stats);
  }
}

/// Solves, then with new tangents until u meets the cones and stands. @returns false when the
/// rounds ran out first
bool ChanceQp::MeetCones(const QuadraticCost& cost, const ConstraintSet& set, int max_rounds,
                         Answer& answer) {
  const Vec<kMaxRows>* lambda = &SolveOnce(answer);
  Evaluate(set, answer.u);
  bool met = Meets(set, answer.u);
  while (!met && answer.stats.rounds < max_rounds &&
         answer.stats.status != QpStatus::kInfeasible) {  // more rows do not help

    const Controls last = answer.u;
    PoseAbout(cost, set, last, *lambda);
    lambda = &SolveOnce(answer);
    Evaluate(set, answer.u);
    met = Meets(set, answer.u) && (answer.u - last).squaredNorm() < kStepTolerance * kStepTolerance;
  }
  return met;
}

/// False: nothing in reach keeps the rows, or none was found in half of the rounds.
bool ChanceQp::SolveInReach(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
                            const Controls& u0, Answer& answer) {
  Pose(cost, set, mode, u0);
  qp_.lb = set.lb.cwiseMax(set.reach_lb);
  qp_.ub = set.ub.cwiseMin(set.reach_ub);
  if (mode == SvfiMode::kExact) {
    return MeetCones(cost, set, std::max(max_rounds_ / 2, 1), answer) &&
           answer.stats.status == QpStatus::kOptimal;
  }
  SolveOnce(answer);
  Evaluate(set, answer.u);
  return answer.stats.status == QpStatus::kOptimal;
}

void ChanceQp::SolveInBox(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
                          const Controls& u0, Answer& answer) {
  answer.stats.status = QpStatus::kOptimal;
  Pose(cost, set, mode, u0);
  if (mode == SvfiMode::kExact) {
    answer.stats.fallbacks = MeetCones(cost, set, max_rounds_, answer) ? 0 : FallBack(set);
    if (answer.stats.fallbacks > 0) {
      qp_.H = cost.H;
      qp_.g = cost.g;
      SolveOnce(answer);
      Evaluate(set, answer.u);
    }
  } else {
    SolveOnce(answer);
    Evaluate(set, answer.u);
  }
  if (mode != SvfiMode::kPreviousVelocity) {  // that mode is as published: it may under-estimate
    Shorten(set, answer);
  }
}

ChanceQp::Answer ChanceQp::Solve(const QuadraticCost& cost, const ConstraintSet& set, SvfiMode mode,
                                 const Controls& u0) {
  Answer answer;
  const bool all_in_reach =
      (set.reach_lb - set.lb).maxCoeff() <= 0 && (set.ub - set.reach_ub).maxCoeff() <= 0;
  if (all_in_reach || !SolveInReach(cost, set, mode, u0, answer)) {
    answer.stats.out_of_reach = !all_in_reach;
    SolveInBox(cost, set, mode, u0, answer);
  }
  for (int k = 0; k < set.chance.size(); ++k) {
    CountRow(set.chance[k], excess_[k], answer.stats);
  }
  return answer;
}

}  // namespace pipewright
