// SPDX-License-Identifier: MIT
#pragma once

#include "perception/scene.h"

namespace pipewright {

/// Whether an estimate can be what it says: every number finite, directions of length one, extents
/// in order, a radius above zero; its covariance symmetric, positive semidefinite and not zero.
/// Nothing measured is certain, and a variance below zero would let the robot nearer the less is
/// known. To 1e-9 of the covariance's trace. Some 5 us for a pipe.
bool Sound(const PlaneEstimate& plane);
bool Sound(const PipeEstimate& pipe);

}  // namespace pipewright
