// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "hil/qpb/qpb.h"

namespace pipewright::hil {

/// What in a problem is not as QpbProblem says, in words; empty when all is. The sizes of its
/// arrays agree.
std::string ProblemError(const QpbProblem& p);

}  // namespace pipewright::hil
