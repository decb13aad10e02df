// SPDX-License-Identifier: MIT
#pragma once

#include "hil/report/world_picture.h"
#include "hil/world/scenario.h"
#include "hil/world/truth.h"

namespace pipewright::hil {

/// The picture's content from a world and what happened in it: the surface with its coverage, the
/// edges of boxes and cylinders. The hand's path and the goals are left to the caller.
/// @param truth  null: not known, so no surface is drawn
WorldView ViewOf(const Scenario& scenario, const Truth* truth);

}  // namespace pipewright::hil
