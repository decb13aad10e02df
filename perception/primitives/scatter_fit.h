// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "perception/primitives/fit.h"

namespace pipewright {

/// Total least squares over points of unknown view whose errors are normal and even, the same in
/// every direction: those of unorganised clouds. Their spread is taken from the residuals.
///
/// A plane through the mean c across the least eigenvector n of S = Σ (p − c)(p − c)':
///   σ² = λ_n / (N − 3),   var(tilt along e_i) = σ²/λ_i,   var(n'c) = σ²/N
///
/// The normal points to S's origin (d < 0). `gate` as for FitPlane; chi2 is that of sigma_m.
///
/// @returns kInfeasible with less than 4 points, on a line, or through S's origin.
/// Cost: O(points), ~3 ns each.
Result<PlaneFit> FitScatteredPlane(std::span<const Eigen::Vector3f> p_SQ, double sigma_m,
                                   const InlierGate& gate = {});

/// Gauss-Newton from `start` on ρ − r − σ²/2r, where the last is the bias of ρ by the error around
/// the axis. Tells as FitCylinder does.
/// Cost: O(points), ~0.1 us each.
Result<CylinderFit> FitScatteredCylinder(std::span<const Eigen::Vector3f> p_SQ,
                                         const CylinderFit& start, double sigma_m,
                                         const InlierGate& gate = {});

}  // namespace pipewright
