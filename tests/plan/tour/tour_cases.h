// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "plan/tour/tour_problem.h"

namespace pipewright::test {

/// A problem that owns its costs.
struct TourCase {
  int n = 0;
  std::vector<float> costs = {};
  bool open = false;
  int entry = TourProblem::kFree;
  int exit = TourProblem::kFree;

  TourProblem Problem() const {
    return {.n = n, .costs = costs, .open = open, .entry = entry, .exit = exit};
  }
};

enum class Costs : std::uint8_t {
  kAny,        ///< whole numbers, each on its own; many are equal
  kSymmetric,  ///< the same, but one number both ways
  kPlane,      ///< distances of points in a square: symmetric, not whole
  kUphill,     ///< such distances, dearer upwards: not symmetric, not whole
};

/// Closed. The diagonal is not a number, since none may read it.
TourCase RandomTour(int n, Costs costs, std::uint64_t seed);

/// The least cost of all permutations that keep the ends; n <= 8.
double LeastOfAll(const TourProblem& problem);

/// Whether each node is there once, and the ends are where they were given.
bool IsTour(const TourProblem& problem, const std::vector<TourNode>& order);

}  // namespace pipewright::test
