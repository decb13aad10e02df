// SPDX-License-Identifier: MIT
#pragma once

#include "ctrl/constraints/row_maker.h"
#include "ctrl/constraints/world_rows.h"

namespace pipewright {

/// The pairs of RobotShapes that could touch: capsule with capsule, capsule with a box of the base.
void AddSelfRows(const RowContext& context, RowMaker& maker, Clearances& clearance);

}  // namespace pipewright
