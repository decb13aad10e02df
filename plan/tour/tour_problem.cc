// SPDX-License-Identifier: MIT
#include "plan/tour/tour_problem.h"

namespace pipewright {
namespace {

Status CheckEnds(const TourProblem& p) {
  const auto valid = [&](int end) { return end == TourProblem::kFree || (0 <= end && end < p.n); };
  if (!valid(p.entry) || !valid(p.exit)) {
    return Status::kOutOfRange;
  }
  if (!p.open && (p.entry != TourProblem::kFree || p.exit != TourProblem::kFree)) {
    return Status::kMalformed;
  }
  if (p.entry != TourProblem::kFree && p.entry == p.exit && p.n > 1) {
    return Status::kInfeasible;
  }
  return Status::kOk;
}

}  // namespace

Status CheckTour(const TourProblem& p) {
  if (p.n < 1) {
    return Status::kOutOfRange;
  }
  if (p.costs.size() != static_cast<std::size_t>(p.n) * static_cast<std::size_t>(p.n)) {
    return Status::kMalformed;
  }
  if (const Status ends = CheckEnds(p); ends != Status::kOk) {
    return ends;
  }
  for (int i = 0; i < p.n; ++i) {
    for (int j = 0; j < p.n; ++j) {
      const float cost = p.Cost(i, j);
      if (i != j && !(0 <= cost && cost <= TourProblem::kCostMax)) {  // NaN fails, too
        return Status::kOutOfRange;
      }
    }
  }
  return Status::kOk;
}

double TourCost(const TourProblem& p, std::span<const TourNode> order) {
  double sum = 0;
  for (std::size_t k = 1; k < order.size(); ++k) {
    sum += p.Cost(order[k - 1], order[k]);
  }
  return p.open || order.size() < 2 ? sum : sum + p.Cost(order.back(), order.front());
}

}  // namespace pipewright
