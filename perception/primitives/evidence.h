// SPDX-License-Identifier: MIT
#pragma once

#include "perception/primitives/depth_view.h"
#include "perception/scene.h"

namespace pipewright {

/// Readings on rays that should end on a primitive.
struct Evidence {
  int agree = 0;    ///< end on it
  int through = 0;  ///< end behind it: it is not there
  int hidden = 0;   ///< end before it: they say nothing

  int told() const { return agree + through; }
};

/// What a frame says of a primitive, within the part of it that was seen. `step`: every step-th
/// pixel of every step-th row is asked.
Evidence LookAt(const DepthView& view, const PlaneEstimate& plane, const DepthNoise& noise,
                int step);
Evidence LookAt(const DepthView& view, const PipeEstimate& pipe, const DepthNoise& noise, int step);

}  // namespace pipewright
