// SPDX-License-Identifier: MIT
#include "plan/tour/cost_table.h"

#include <limits>

namespace pipewright {
namespace {

bool IsSymmetric(const TourProblem& p) {
  for (int i = 0; i < p.n; ++i) {
    for (int j = 0; j < i; ++j) {
      if (p.Cost(i, j) != p.Cost(j, i)) {
        return false;
      }
    }
  }
  return true;
}

float LargestCost(const TourProblem& p) {
  float largest = 0;
  for (int i = 0; i < p.n; ++i) {
    for (int j = 0; j < p.n; ++j) {
      largest = i == j ? largest : std::max(largest, p.Cost(i, j));
    }
  }
  return largest;
}

}  // namespace

CostTable::CostTable(int node_capacity, int floats_min) {
  const auto nodes = static_cast<std::size_t>(node_capacity) + 1;
  costs_.resize(std::max(nodes * nodes, static_cast<std::size_t>(floats_min)));
}

void CostTable::Load(const TourProblem& problem, bool may_be_symmetric) {
  n_ = problem.n + (problem.open ? 1 : 0);
  dummy_ = problem.open ? problem.n : -1;
  symmetric_ = may_be_symmetric && IsSymmetric(problem);
  forbidden_ = std::numeric_limits<float>::infinity();
  dummy_cost_ = 0;
  for (int i = 0; i < problem.n; ++i) {
    float* row = &costs_[static_cast<std::size_t>(i) * n_];
    for (int j = 0; j < problem.n; ++j) {
      row[j] = i == j ? kNever : problem.Cost(i, j);
    }
  }
  if (problem.open) {
    AddDummy(problem);
  }
}

void CostTable::AddDummy(const TourProblem& p) {
  forbidden_ = 4 * std::max(LargestCost(p), std::numeric_limits<float>::min());
  const bool entry_given = p.entry != TourProblem::kFree;
  const bool exit_given = p.exit != TourProblem::kFree;
  // Symmetric, with one end given: one of the dummy's two ways leads to a node that is free.
  dummy_cost_ = symmetric_ && entry_given != exit_given ? forbidden_ : 0;
  const auto cost = [&](int node, bool given, int end) {
    const bool allowed = symmetric_ ? (!entry_given && !exit_given) || node == p.entry ||  //
                                          node == p.exit
                                    : !given || node == end;
    return allowed ? 0 : forbidden_;
  };
  float* out = &costs_[static_cast<std::size_t>(dummy_) * n_];
  for (int i = 0; i < p.n; ++i) {
    out[i] = cost(i, entry_given, p.entry);
    costs_[static_cast<std::size_t>(i) * n_ + dummy_] = cost(i, exit_given, p.exit);
  }
  out[dummy_] = kNever;
}

void CostTable::Reduce(std::span<const float> u, std::span<const float> v) {
  for (int i = 0; i < n_; ++i) {
    float* row = &costs_[static_cast<std::size_t>(i) * n_];
    for (int j = 0; j < n_; ++j) {
      row[j] -= u[i] + v[j];  // the sum first: it is the same for (j, i) where u = v
    }
  }
}

std::span<float> CostTable::Spare() {
  return std::span(costs_).subspan(static_cast<std::size_t>(n_) * n_);
}

}  // namespace pipewright
