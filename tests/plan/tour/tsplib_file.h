// SPDX-License-Identifier: MIT
#pragma once

#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plan/tour/tour_problem.h"

namespace pipewright::test {

/// An instance of TSPLIB. [Reinelt: TSPLIB 95, section 2]
struct TsplibInstance {
  std::string name;
  int n = 0;
  std::vector<float> costs;  ///< n×n, row-major; the diagonal as it stands in the file

  TourProblem Problem() const { return {.n = n, .costs = costs}; }
};

struct TsplibResult {
  std::optional<TsplibInstance> instance;  ///< whole, or nothing
  std::string error;                       ///< FILE:LINE: and what is wrong there
};

/// Reads TYPE TSP or ATSP with EDGE_WEIGHT_TYPE EXPLICIT as a FULL_MATRIX, or EUC_2D (rounded, as
/// TSPLIB asks). Of 2 to 4096 nodes. `file` names it in errors.
TsplibResult ReadTsplib(std::istream& in, const std::string& file);
TsplibResult ReadTsplibFile(const std::string& path);

/// The proven optimum of a TSPLIB instance, of those that are listed here.
std::optional<double> TsplibOptimum(std::string_view name);

}  // namespace pipewright::test
