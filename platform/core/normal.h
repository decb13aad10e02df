// SPDX-License-Identifier: MIT
#pragma once

namespace pipewright {

/// The standard normal distribution function and its inverse, in arithmetic whose order is fixed,
/// so that one input gives one output on every machine (erf of two C libraries may differ).
/// No heap, no table but constants; NaN in gives NaN out.

/// Phi(x) = 1/sqrt(2 pi) integral from -inf to x of exp(-t^2 / 2) dt.
///
/// Relative error <= 1e-15 from x = -37.5 up (below, the value is denormal or 0).
/// Cost: some 100 multiply-adds, no iteration.
double NormalCdf(double x);

/// phi(x) = exp(-x^2 / 2) / sqrt(2 pi).
double NormalPdf(double x);

/// The z with Phi(z) = p. p = 0 gives -inf, p = 1 gives +inf, outside [0, 1] NaN.
///
/// Relative error <= 1e-15 of the p that is given. Symmetric: for p > 1/2 it is
/// -NormalQuantile(1 - p). Cost: three evaluations of NormalCdf.
double NormalQuantile(double p);

}  // namespace pipewright
