// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>

#include "perception/primitives/config.h"
#include "platform/core/frames.h"
#include "platform/core/status.h"

namespace pipewright {

/// A plane n'x = d in S, |n| = 1, n towards the camera: d < 0.
struct PlaneFit {
  Vector3d n_S = -Vector3d::UnitZ();
  double d_m = -1;
  Mat<4, 4> covariance = Mat<4, 4>::Zero();  ///< of (n, d), rank 3
  double chi2 = 0;                           ///< per degree of freedom
  int count = 0;
};

/// m = n/d: the plane's inverse depth along the ray x = (X/Z, Y/Z, 1) is m'x.
inline Eigen::Vector3f InverseDepth(const PlaneFit& fit) {
  return (fit.n_S / fit.d_m).cast<float>();
}

/// A cylinder in S: axis through p along l, |l| = 1; p is the axis point nearest to the points'
/// mean.
struct CylinderFit {
  Vector3d p_S = Vector3d::Zero();
  Vector3d l_S = Vector3d::UnitX();
  double radius_m = 0;
  Mat<7, 7> covariance = Mat<7, 7>::Zero();  ///< of (p, l, r), rank 5
  double chi2 = 0;
  int count = 0;
};

/// How readings came to be called inliers: those within `sigmas` of their noise, and slack_m more
/// across the surface, of the shape they are then fitted to.
struct InlierGate {
  double sigmas = std::numeric_limits<double>::infinity();
  double slack_m = 0;
};

/// What a normal reading that is only kept within c sigmas still tells of where its mean is, as a
/// share: with φ the density and P the probability of being kept,
///   η = 1 − 2 c φ(c) / P
/// It is also the variance of what is kept. Least squares on such readings, gated anew until it
/// settles, has covariance N⁻¹/η: their cut tails have followed the fit.
double KeptInformation(double c);

/// Least squares over given inliers, which a camera at S's origin saw.
///
/// On a plane the inverse depth is linear in the ray x = (X/Z, Y/Z, 1):  1/z = m'x, m = n/d. A
/// reading errs in z, so that 1/z is biased by σ²/z³; its tangent at the plane's ŵ = m'x is not:
///   residual  ŵ² (1/ŵ − z),  σ = noise of 1/z at ŵ;    N = Σ xx'/σ²,  cov(m) = N⁻¹ max(1, chi2)
/// chi2 counts only where it is larger than chance allows.
///
/// @returns kInfeasible with less than 4 points, or where they do not span a plane that the camera
///          can see from outside.
/// Cost: O(points), ~10 ns each.
Result<PlaneFit> FitPlane(std::span<const Eigen::Vector3f> p_SQ, const DepthNoise& noise,
                          const InlierGate& gate = {});
/// One step of it from m = n/d that is near: at half the cost, and as good.
Result<PlaneFit> FitPlane(std::span<const Eigen::Vector3f> p_SQ, Vector3d m,
                          const DepthNoise& noise, const InlierGate& gate);

/// Gauss-Newton from `start` in 5 parameters: p and l across the axis, r. First on the distances
/// ρ − r to the surface, which lead there from afar; then on the depths along each ray, which are
/// unbiased.
///
/// @returns kInfeasible with less than 6 points or when they leave a parameter free,
///          kIterationLimit when 12 steps do not settle.
/// Cost: O(points), ~0.3 us each.
Result<CylinderFit> FitCylinder(std::span<const Eigen::Vector3f> p_SQ, const CylinderFit& start,
                                const DepthNoise& noise, const InlierGate& gate = {});

/// The second half of it, from a start that is near.
/// @returns kInfeasible also where less than 0.6 of the rays meet the cylinder.
Result<CylinderFit> FitCylinderAlongRays(std::span<const Eigen::Vector3f> p_SQ,
                                         const CylinderFit& start, const DepthNoise& noise,
                                         const InlierGate& gate = {});

/// A ray that meets a surface at a smaller cosine grazes it.
inline constexpr double kGrazing = 0.2;

/// Noise of a point's distance to a surface with normal g, seen along the ray p. A grazing ray
/// would be trusted without end: its cosine counts as kGrazing at least.
double SurfaceSigma(const Vector3d& p_SQ, const Vector3d& g_S, const DepthNoise& noise);

}  // namespace pipewright
