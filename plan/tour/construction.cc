// SPDX-License-Identifier: MIT
#include "plan/tour/construction.h"

#include <algorithm>

namespace pipewright {
namespace {

constexpr TourNode kNobody = -1;

}  // namespace

Construction::Construction(int node_capacity) : visited_(node_capacity) {}

/// The cheapest neighbour that is left, at one in five the one after it; else of all nodes.
TourNode Construction::NextAfter(TourNode a, const CostTable& costs, const Neighbours& neighbours,
                                 Rng& rng) const {
  constexpr double kShareOfFirst = 0.8;
  TourNode chosen = kNobody;
  for (const TourNode b : neighbours.Out(a)) {
    if (visited_[b] != 0) {
      continue;
    }
    if (chosen != kNobody || rng.Uniform() < kShareOfFirst) {
      return b;
    }
    chosen = b;
  }
  if (chosen != kNobody) {
    return chosen;
  }
  for (int b = 0; b < costs.size(); ++b) {
    if (visited_[b] == 0 && (chosen == kNobody || costs(a, b) < costs(a, chosen))) {
      chosen = static_cast<TourNode>(b);
    }
  }
  return chosen;
}

void Construction::Build(const TourProblem& problem, const CostTable& costs,
                         const Neighbours& neighbours, Rng& rng, std::span<TourNode> order) {
  const int n = costs.size();
  std::fill_n(visited_.begin(), n, std::uint8_t{0});
  int count = 0;
  const auto visit = [&](int a) {
    order[count++] = static_cast<TourNode>(a);
    visited_[a] = 1;
  };
  int end = n;
  visit(problem.open ? costs.dummy() : rng.Index(n));
  if (problem.entry != TourProblem::kFree) {
    visit(problem.entry);
  }
  if (problem.exit != TourProblem::kFree) {
    order[--end] = static_cast<TourNode>(problem.exit);
    visited_[problem.exit] = 1;
  }
  while (count < end) {
    visit(NextAfter(order[count - 1], costs, neighbours, rng));
  }
}

}  // namespace pipewright
