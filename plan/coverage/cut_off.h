// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "plan/tour/tour_problem.h"

namespace pipewright {

/// Finds the nodes for whose sake no tour can do without a way that costs `blocked` or more. With
/// the ways left, a node can be
///
///   passed  where one leads to it and another from it, from and to different nodes if n > 2
///   begun   where one leads from it, and the entry is it or free
///   ended   where one leads to it, and the exit is it or free
///
/// and is cut off if none of it; so is each of several that could only begin one tour, or only end
/// it. Ways that no tour takes do not count: to the entry, from the exit, between the two beside
/// others. Where none is found, there may still be no tour: two parts may be cut off, of many nodes
/// each.
///
/// O(n²), n >= 2. `found` is overwritten, ascending; n places are enough.
void FindCutOff(const TourProblem& problem, double blocked, std::vector<TourNode>& found);

}  // namespace pipewright
