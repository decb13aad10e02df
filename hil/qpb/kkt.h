// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "hil/qpb/qpb.h"

namespace pipewright::hil {

/// A claimed optimum of a QpbProblem, slacks included. Multipliers of Ai and of the box are >= 0
/// where the upper side is touched, <= 0 where the lower one is.
struct QpbPoint {
  std::vector<double> x;
  std::vector<double> nu;      ///< of Ae
  std::vector<double> lambda;  ///< of Ai
  std::vector<double> mu;      ///< of lb, ub
};

/// How far a point is from the KKT conditions in the file's own numbers, relative: the largest of
///
///   stationarity     |Hx + g + Ae'nu + Ai'lambda + mu| / S,   S = max(1, largest term of the sums)
///   feasibility      distance of a_i'x from [l_i, u_i], over s_i = max(1, largest |a_ij x_j|)
///   complementarity  min(|lambda_i| / S, distance of a_i'x from the side that the sign of
///                    lambda_i names, over s_i)
///
/// where Ae and the box are rows like those of Ai. What is not a number gives infinity.
double KktResidual(const QpbProblem& p, const QpbPoint& at);

}  // namespace pipewright::hil
