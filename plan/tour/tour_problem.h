// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "platform/core/status.h"

namespace pipewright {

/// A place to be visited, counted from 0.
using TourNode = std::int16_t;

/// Visit n nodes, each once, at the least cost: a closed tour ends where it began, an open one is a
/// path between two given nodes, or from or to any node where an end is free.
///
///   closed  minimise Σ c(t_k, t_(k+1 mod n))            over permutations t
///   open    minimise Σ c(t_k, t_(k+1)), k < n − 1,      t_0 = entry, t_(n−1) = exit where given
///
/// Costs may differ from way to way (ATSP) and need not obey the triangle inequality.
struct TourProblem {
  static constexpr int kFree = -1;
  static constexpr float kCostMax = 1e12F;

  int n = 0;
  /// n×n, row-major, from row to column, any unit; finite, within [0, kCostMax]. Its diagonal is
  /// not read. A way that must not be taken has a cost beyond any tour's.
  std::span<const float> costs = {};
  bool open = false;
  int entry = kFree;  ///< first node of an open tour
  int exit = kFree;   ///< last node of an open tour

  float Cost(int from, int to) const { return costs[static_cast<std::size_t>(from) * n + to]; }
};

/// Whether a problem is as TourProblem says. O(n²)
/// @returns kOk; kOutOfRange: n < 1, a cost or an end beyond its limits, or not finite; kMalformed:
///   the costs are not n×n, or a closed tour has ends; kInfeasible: entry = exit, and n > 1
Status CheckTour(const TourProblem& problem);

/// Σ of the costs along a permutation of the problem's nodes, closed or open as the problem is.
double TourCost(const TourProblem& problem, std::span<const TourNode> order);

}  // namespace pipewright
