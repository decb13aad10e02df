// SPDX-License-Identifier: MIT
#pragma once

namespace pipewright {

/// The standard normal distribution function and its inverse, in arithmetic whose order is fixed,
/// so that one input gives one output on every machine (erf of two C libraries may differ).
/// No heap, no table but constants; NaN in gives NaN out.

/// Phi(x) = 1/sqrt(2 pi) integral from -inf to x of exp(-t^2 / 2) dt.
///
/// Relative error <= 1e-15 for -1.5 <= x, <= 3e-15 down to x = -37.5 (beyond, the value is
/// denormal or 0). Cost: at most 60 multiply-adds, 40 divisions, one exponential.
double NormalCdf(double x);

/// phi(x) = exp(-x^2 / 2) / sqrt(2 pi).
double NormalPdf(double x);

/// The z with Phi(z) = p. p = 0 gives -inf, p = 1 gives +inf, outside [0, 1] NaN.
///
/// Relative error <= 1e-15, or, about p = 1/2 and towards p = 1, what the rounding of p itself
/// allows. Symmetric: for p > 1/2 it is -NormalQuantile(1 - p).
double NormalQuantile(double p);

}  // namespace pipewright
