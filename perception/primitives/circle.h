// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "perception/primitives/fit.h"

namespace pipewright {

/// The circle across l_S through points (least squares, algebraic): x² + y² + Dx + Ey + F = 0. Sets
/// p, l and r of `pipe`, and tells whether there is one. A start for a fit, not an estimate.
bool CircleAcross(const Vector3d& l_S, std::span<const Eigen::Vector3f> p_SQ, CylinderFit& pipe);

}  // namespace pipewright
