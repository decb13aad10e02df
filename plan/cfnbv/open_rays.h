// SPDX-License-Identifier: MIT
#pragma once

#include "plan/gain/gain.h"
#include "plan/goal.h"

namespace pipewright {

/// The rays of `camera` that meet no part of the robot in q: what a view from there can show.
///
/// A part blocks a ray where its box does, in which MakeCloud takes a reading for the robot's own
/// too; what the sensor is built into does not. `open` may be nothing. O(rays * parts), no heap.
void OpenRays(const Configuration& q, const RaySet& camera, RaySet& open);

}  // namespace pipewright
