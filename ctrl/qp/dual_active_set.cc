// SPDX-License-Identifier: MIT
#include "ctrl/qp/dual_active_set.h"

#include "ctrl/qp/dual_active_set_inl.h"

namespace pipewright {

template class QpSolver<kControlQpVariables, kControlQpRows>;

}  // namespace pipewright
