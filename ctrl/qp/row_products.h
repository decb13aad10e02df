// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/qp/qp.h"

namespace pipewright::qp {

using Block = Eigen::Array<double, 8, 1>;

/// a_i'x for eight rows from `first` on, a multiple of eight. Column by column, so that the sums
/// of the eight rows stay in registers. Rows past the last one give whatever lies there.
template <int n, int m, typename X>
Block ProductBlock(const QpProblem<n, m>& qp, const X& x, int first) {
  Block y = qp.A.col(0).template segment<8>(first).array() * x[0];
  for (int j = 1; j < n; ++j) {
    y += qp.A.col(j).template segment<8>(first).array() * x[j];
  }
  return y;
}

}  // namespace pipewright::qp
