// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "perception/primitives/scatter_detector.h"
#include "perception/primitives/scatter_fit.h"

namespace pipewright {
namespace {

constexpr int kRounds = 4;
constexpr float kNormalOnPlane = 0.8F;  // cosine
constexpr float kNormalOnPipe = 0.7F;
constexpr int kCells = 16;  // a side of the rectangle whose fill is asked
constexpr int kArcBins = 18;
constexpr int kAlongBins = 6;
constexpr double kReach_m = 10;  // along a pipe
constexpr double kBin_m = 0.1;
constexpr int kBins = 200;
constexpr int kMaxGapBins = 3;

}  // namespace

int ScatterDetector::CollectPlane(const PlaneFit& plane) {
  const double limit_m = config_.inlier_sigmas * config_.sigma_m;
  const Eigen::Vector3f n = plane.n_S.cast<float>();
  int count = 0;
  for (int i = 0; i < points_; ++i) {
    const bool across =
        n_S_[i] == Eigen::Vector3f::Zero() || std::abs(n.dot(n_S_[i])) > kNormalOnPlane;
    if (barred_[i] == kFree && across &&
        std::abs(plane.n_S.dot(p_S_[i].cast<double>()) - plane.d_m) < limit_m) {
      index_[count] = i;
      agreeing_[count++] = p_S_[i];
    }
  }
  return count;
}

bool ScatterDetector::RefinePlane(DetectedPlane& plane) {
  const int least =
      std::max(config_.plane_min_points, static_cast<int>(config_.plane_min_share * points_));
  int count = 0;
  for (int round = 0; round < kRounds; ++round) {
    count = CollectPlane(plane.fit);
    if (count < least) {
      return false;
    }
    const auto fitted =
        FitScatteredPlane(Agreeing(count), config_.sigma_m, {config_.inlier_sigmas});
    if (!fitted.ok()) {
      return false;
    }
    plane.fit = *fitted;
  }
  return plane.fit.chi2 < config_.chi2_max && BoundPlane(count, plane);
}

/// The rectangle about all but the outermost hundredth of the points a side; whether it is filled.
bool ScatterDetector::BoundPlane(int count, DetectedPlane& plane) {
  const auto axes = RectangleAxes(plane.fit.n_S, Vector3d::UnitZ(), Vector3d::UnitX());
  plane.e1_S = axes.col(0);
  plane.e2_S = axes.col(1);
  plane.p_SCentroid.setZero();
  for (int k = 0; k < count; ++k) {
    plane.p_SCentroid += agreeing_[k].cast<double>() / count;
  }
  const auto along = [&](int a, int k) {
    return static_cast<float>(axes.col(a).dot(agreeing_[k].cast<double>() - plane.p_SCentroid));
  };
  for (int a = 0; a < 2; ++a) {
    for (int k = 0; k < count; ++k) {
      along_m_[k] = along(a, k);
    }
    const auto at = [&](int rank) {
      std::nth_element(along_m_.begin(), along_m_.begin() + rank, along_m_.begin() + count);
      return static_cast<double>(along_m_[rank]);
    };
    plane.lo_m[a] = at(count / 100);
    plane.hi_m[a] = at(count - 1 - count / 100);
  }
  const double sides_m[2] = {plane.hi_m[0] - plane.lo_m[0], plane.hi_m[1] - plane.lo_m[1]};
  if (std::min(sides_m[0], sides_m[1]) < config_.plane_min_extent_m) {
    return false;
  }
  std::array<bool, kCells * kCells> filled{};
  for (int k = 0; k < count; ++k) {
    int cell[2];
    for (int a = 0; a < 2; ++a) {
      cell[a] = static_cast<int>((along(a, k) - plane.lo_m[a]) / sides_m[a] * kCells);
      cell[a] = std::clamp(cell[a], 0, kCells - 1);
    }
    filled[cell[0] * kCells + cell[1]] = true;
  }
  return static_cast<double>(std::count(filled.begin(), filled.end(), true)) >=
         config_.plane_min_fill * kCells * kCells;
}

bool ScatterDetector::OnPipe(int i, const CylinderFit& pipe, bool by_normal, double& s_m) const {
  const Vector3d w = p_S_[i].cast<double>() - pipe.p_S;
  s_m = pipe.l_S.dot(w);
  const Vector3d across = w - s_m * pipe.l_S;
  const double rho = std::sqrt(across.squaredNorm());
  const bool agrees = !by_normal || n_S_[i] == Eigen::Vector3f::Zero() ||
                      std::abs(n_S_[i].dot(across.cast<float>())) > kNormalOnPipe * rho;
  return std::abs(rho - pipe.radius_m) < config_.inlier_sigmas * config_.sigma_m && agrees &&
         std::abs(s_m) < kReach_m;
}

/// The points on a pipe, of the stretch about the fullest part of its axis; its ends.
int ScatterDetector::CollectPipe(const CylinderFit& pipe, bool by_normal, DetectedPipe& bounds) {
  const auto bin_of = [](double s_m) {
    return std::clamp(static_cast<int>(std::floor(s_m / kBin_m)) + kBins / 2, 0, kBins - 1);
  };
  std::array<int, kBins> histogram{};
  double s_m = 0;
  for (int i = 0; i < points_; ++i) {
    if (barred_[i] == kFree && OnPipe(i, pipe, by_normal, s_m)) {
      ++histogram[bin_of(s_m)];
    }
  }
  const int fullest =
      static_cast<int>(std::max_element(histogram.begin(), histogram.end()) - histogram.begin());
  int first = fullest;
  int last = fullest;
  for (int bin = fullest; bin >= 0 && first - bin <= kMaxGapBins; --bin) {
    first = histogram[bin] > 0 ? bin : first;
  }
  for (int bin = fullest; bin < kBins && bin - last <= kMaxGapBins; ++bin) {
    last = histogram[bin] > 0 ? bin : last;
  }
  bounds.fit = pipe;
  bounds.lo_m = 1e9;
  bounds.hi_m = -1e9;
  int count = 0;
  for (int i = 0; i < points_; ++i) {
    if (barred_[i] != kFree || !OnPipe(i, pipe, by_normal, s_m) || bin_of(s_m) < first ||
        bin_of(s_m) > last) {
      continue;
    }
    bounds.lo_m = std::min(bounds.lo_m, s_m);
    bounds.hi_m = std::max(bounds.hi_m, s_m);
    index_[count] = i;
    agreeing_[count++] = p_S_[i];
  }
  return count;
}

bool ScatterDetector::RefinePipe(DetectedPipe& pipe) {
  DetectedPipe bounds;
  int count = 0;
  for (int round = 0; round < kRounds; ++round) {
    // The normals of a thin pipe's sides are poor: they lead there, and choose no more at the end.
    count = CollectPipe(pipe.fit, /*by_normal=*/2 * round < kRounds, bounds);
    if (count < config_.pipe_min_points) {
      return false;
    }
    const auto fitted =
        FitScatteredCylinder(Agreeing(count), pipe.fit, config_.sigma_m, {config_.inlier_sigmas});
    if (!fitted.ok() || fitted->radius_m > 1.5 * config_.pipe_radius_max_m) {
      return false;
    }
    pipe.fit = *fitted;
  }
  const double moved_m = pipe.fit.l_S.dot(pipe.fit.p_S - bounds.fit.p_S);
  pipe.lo_m = bounds.lo_m - moved_m;
  pipe.hi_m = bounds.hi_m - moved_m;
  return IsPipe(count, pipe);
}

/// Whether what was fitted is round, long enough, and seen from enough of its sides.
bool ScatterDetector::IsPipe(int count, const DetectedPipe& pipe) const {
  const CylinderFit& fit = pipe.fit;
  const double length_m = pipe.hi_m - pipe.lo_m;
  if (fit.radius_m < config_.pipe_radius_min_m || fit.radius_m > config_.pipe_radius_max_m ||
      fit.chi2 > config_.chi2_max || length_m < config_.pipe_min_length_m ||
      length_m < 2 * fit.radius_m) {
    return false;
  }
  const Vector3d e1 = fit.l_S.unitOrthogonal();
  const Vector3d e2 = fit.l_S.cross(e1);
  std::array<std::array<bool, kAlongBins>, kArcBins> filled{};
  std::array<bool, kArcBins> seen{};
  for (int k = 0; k < count; ++k) {
    const Vector3d w = agreeing_[k].cast<double>() - fit.p_S;
    const double turns = std::atan2(e2.dot(w), e1.dot(w)) / (2 * std::numbers::pi);
    const double share = (fit.l_S.dot(w) - pipe.lo_m) / length_m;
    const int arc = std::clamp(static_cast<int>((turns + 0.5) * kArcBins), 0, kArcBins - 1);
    const int along = std::clamp(static_cast<int>(share * kAlongBins), 0, kAlongBins - 1);
    seen[arc] = filled[arc][along] = true;
  }
  int cells = 0;
  for (const auto& arc : filled) {
    cells += static_cast<int>(std::count(arc.begin(), arc.end(), true));
  }
  const auto arcs = static_cast<int>(std::count(seen.begin(), seen.end(), true));
  if (arcs * 2 * std::numbers::pi / kArcBins < config_.pipe_min_arc_rad ||
      cells < config_.pipe_min_fill * arcs * kAlongBins) {
    return false;
  }
  // A wall's strip or a heap of points goes on beyond the gate, a pipe's shell does not.
  int beside = 0;
  for (int i = 0; i < points_; ++i) {
    const Vector3d w = p_S_[i].cast<double>() - fit.p_S;
    const double s_m = fit.l_S.dot(w);
    const double rho_m = std::sqrt(std::max(0.0, w.squaredNorm() - s_m * s_m));
    const double gates = std::abs(rho_m - fit.radius_m) / (config_.inlier_sigmas * config_.sigma_m);
    beside += gates > 1 && gates < 2 && s_m > pipe.lo_m && s_m < pipe.hi_m;
  }
  if (beside > config_.pipe_max_beside * count) {
    return false;
  }
  const auto plane = FitScatteredPlane(Agreeing(count), config_.sigma_m, {config_.inlier_sigmas});
  return !plane.ok() || plane->chi2 > config_.pipe_min_roundness * fit.chi2;
}

}  // namespace pipewright
