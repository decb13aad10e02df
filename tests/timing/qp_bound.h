// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace pipewright::timing {

/// Instructions of the controller's QP solver with every row taken and the working set full, the
/// largest over families of forced problems (many soft rows that all pull, rows that nearly repeat
/// one another, rows that were elsewhere the last time). Measured, not proved.
struct QpCost {
  std::uint64_t iteration = 0;  ///< of one: what a solve costs more when it may make one more
  std::uint64_t iteration_median = 0;
  std::uint64_t around = 0;  ///< of a solve that begins and ends with a full set, besides
  int active_max = 0;        ///< rows and bounds that the forced problems held at once
  int iterations_max = 0;    ///< of a forced problem
};

/// By QpSpy, which must be in use.
QpCost MeasureQp(int problems, std::uint64_t seed);

}  // namespace pipewright::timing
