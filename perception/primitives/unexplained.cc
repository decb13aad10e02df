// SPDX-License-Identifier: MIT
#include "perception/primitives/unexplained.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "perception/primitives/fit.h"

namespace pipewright {
namespace {

double Sigma(const Vector3d& p_SQ, const Vector3d& g_S, const PointNoise& noise) {
  return noise.depth ? SurfaceSigma(p_SQ, g_S, *noise.depth) : noise.sigma_m;
}

bool Within(double at_m, double lo_m, double hi_m, double border_m) {
  return lo_m - border_m <= at_m && at_m <= hi_m + border_m;
}

bool IsNoise(double off_m, double sigma_m, double chi2, double sigmas) {
  return std::abs(off_m) <= sigmas * sigma_m * std::sqrt(std::max(1.0, chi2));
}

}  // namespace

bool Explains(const DetectedPlane& plane, const Vector3d& p_SQ, const PointNoise& noise,
              const ExplainConfig& config) {
  const Vector3d w = p_SQ - plane.p_SCentroid;
  if (!Within(plane.e1_S.dot(w), plane.lo_m[0], plane.hi_m[0], config.border_m) ||
      !Within(plane.e2_S.dot(w), plane.lo_m[1], plane.hi_m[1], config.border_m)) {
    return false;
  }
  const Vector3d& n = plane.fit.n_S;
  return IsNoise(n.dot(p_SQ) - plane.fit.d_m, Sigma(p_SQ, n, noise), plane.fit.chi2, config.sigmas);
}

bool Explains(const DetectedPipe& pipe, const Vector3d& p_SQ, const PointNoise& noise,
              const ExplainConfig& config) {
  const Vector3d w = p_SQ - pipe.fit.p_S;
  const double along_m = pipe.fit.l_S.dot(w);
  const Vector3d across = w - along_m * pipe.fit.l_S;
  const double rho_m = across.norm();
  if (!Within(along_m, pipe.lo_m, pipe.hi_m, config.border_m) || !(rho_m > 0)) {
    return false;
  }
  return IsNoise(rho_m - pipe.fit.radius_m, Sigma(p_SQ, across / rho_m, noise), pipe.fit.chi2,
                 config.sigmas);
}

int Unexplained(std::span<const Eigen::Vector3f> p_SQ, std::span<const DetectedPlane> planes,
                std::span<const DetectedPipe> pipes, const PointNoise& noise,
                const ExplainConfig& config, std::span<int> numbers) {
  assert(Valid(config) && numbers.size() >= p_SQ.size());
  int count = 0;
  for (int i = 0; i < static_cast<int>(p_SQ.size()); ++i) {
    const Vector3d p = p_SQ[i].cast<double>();
    const auto explains = [&](const auto& primitive) {
      return Explains(primitive, p, noise, config);
    };
    const bool reading = p.allFinite() && (!noise.depth || p.z() > 0);
    if (reading && std::none_of(planes.begin(), planes.end(), explains) &&
        std::none_of(pipes.begin(), pipes.end(), explains)) {
      numbers[count++] = i;
    }
  }
  return count;
}

}  // namespace pipewright
