// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "perception/primitives/pixel_distance.h"
#include "perception/primitives/plane_finder.h"

namespace pipewright {
namespace {

constexpr double kMinFacing = 0.08;  // cosine to the view below which a plane is seen edge-on
constexpr float kGoesOnSigmas = 15;  // off the plane: farther, it is behind or before it
constexpr int kStraySupport = 5;     // of 9 pixels: with more about it, it is of the plane
constexpr int kMinInner = 40;        // readings that are the plane's beyond doubt
constexpr double kBorder_m = 0.1;

}  // namespace

Eigen::Matrix<double, 3, 2> RectangleAxes(const Vector3d& n, const Vector3d& up,
                                          const Vector3d& forward) {
  constexpr double kNearlyLevel = 0.9;
  Eigen::Matrix<double, 3, 2> axes;
  const bool level = std::abs(n.dot(up)) > kNearlyLevel;
  const Vector3d e1 = level ? Vector3d(forward - n.dot(forward) * n) : Vector3d(up.cross(n));
  axes.col(0) = e1.normalized();
  axes.col(1) = n.cross(axes.col(0));
  return axes;
}

bool Near(const DetectedPlane& plane, const Vector3d& p_SQ, const DepthNoise& noise, double sigmas,
          double least_m) {
  const Vector3d w = p_SQ - plane.p_SCentroid;
  const double a = plane.e1_S.dot(w);
  const double b = plane.e2_S.dot(w);
  if (a < plane.lo_m[0] - kBorder_m || a > plane.hi_m[0] + kBorder_m ||
      b < plane.lo_m[1] - kBorder_m || b > plane.hi_m[1] + kBorder_m) {
    return false;
  }
  const double off_m = std::abs(plane.fit.n_S.dot(p_SQ) - plane.fit.d_m);
  return off_m < least_m || off_m < sigmas * SurfaceSigma(p_SQ, plane.fit.n_S, noise);
}

namespace {

/// Four points, and their noise along the ray over their depth.
struct FourPoints {
  Floats x, y, z;
  Floats sigma_per_m;
};
Floats Dot(const Vector3d& v, const FourPoints& p) {
  return static_cast<float>(v.x()) * p.x + static_cast<float>(v.y()) * p.y +
         static_cast<float>(v.z()) * p.z;
}
Floats Length(const FourPoints& p) { return SquareRoot(p.x * p.x + p.y * p.y + p.z * p.z); }

/// Near() of four points.
Masks Near(const DetectedPlane& plane, const FourPoints& p, float sigmas, float least_m) {
  Masks near = Masks{-1, -1, -1, -1};
  const Vector3d* const axes[] = {&plane.e1_S, &plane.e2_S};
  for (int a = 0; a < 2; ++a) {
    const double center_m = axes[a]->dot(plane.p_SCentroid);
    const Floats at_m = Dot(*axes[a], p);
    near &= (at_m >= static_cast<float>(center_m + plane.lo_m[a] - kBorder_m)) &
            (at_m <= static_cast<float>(center_m + plane.hi_m[a] + kBorder_m));
  }
  const Floats height_m = Dot(plane.fit.n_S, p);
  const Floats off_m = Absolute(height_m - static_cast<float>(plane.fit.d_m));
  const Floats grazing_m = static_cast<float>(kGrazing) * Length(p);
  const Floats sigma_m = Greater(Absolute(height_m), grazing_m) * p.sigma_per_m;
  return near & ((off_m < least_m) | (off_m < sigmas * sigma_m));
}

}  // namespace

/// Measures how many pixels each pixel is from a surface that goes on from the plane and is none of
/// it.
void PlaneFinder::MeasureFromOthers(const DepthView& view, const Eigen::Vector3f& m) {
  for (int i = 0; i < view.size(); ++i) {
    const float w = m.x() * view.x(i) + m.y() * view.y(i) + m.z();
    const bool near_plane = view.seen(i) && mark_[i] != 3 &&
                            std::abs(view.inverse_z(i) - w) * view.inverse_sigma(i) < kGoesOnSigmas;
    from_other_[i] = near_plane && Support(view, i) <= kStraySupport ? 0 : 255;
  }
  SweepDistances(from_other_, view.width(), {0, view.height() - 1, 0, view.width() - 1});
}

/// Unmarks what is kept of a plane m where another surface meets it: within as many pixels of one
/// as a surface that leaves the plane by 45 degrees is in its gate, or near another plane.
void PlaneFinder::MarkCorners(const DepthView& view, const Eigen::Vector3f& m,
                              const DetectedPlane& plane) {
  const auto clear = static_cast<float>(config_.plane_clear_sigmas + config_.inlier_sigmas);
  const auto clear_m = static_cast<float>(2 * config_.plane_clear_m);
  const float gate_pixels = static_cast<float>(config_.inlier_sigmas) * view.focal();
  for (int i = 0; i < view.size(); i += kLanes) {
    const Masks kept = Widen(&mark_[i]) == 3;
    if (!Any(kept)) {
      continue;
    }
    const Floats x = view.four_x(i);
    const Floats y = view.four_y(i);
    const Floats w = m.x() * x + m.y() * y + m.z();
    const Floats z = 1 / w;
    const FourPoints p{x * z, y * z, z, SigmaInverse(w, config_.noise) * z};
    const Floats from_other = __builtin_convertvector(Widen(&from_other_[i]), Floats);
    Masks corner = from_other <= 1 + gate_pixels * p.sigma_per_m;
    for (const DetectedPlane& other : found_) {
      if (&other != &plane) {
        corner |= Near(other, p, clear, clear_m);
      }
    }
    for (int lane = 0; lane < kLanes && Any(corner & kept); ++lane) {
      mark_[i + lane] = corner[lane] != 0 ? 0 : mark_[i + lane];
    }
  }
}

/// The fit without readings where another surface meets the plane, found or not: those of the other
/// within the gate are all on one side. Asked of the planes and of whole neighbourhoods, not of the
/// single reading, so that nothing is chosen by its noise.
bool PlaneFinder::Polish(const DepthView& view, DetectedPlane& plane) {
  const Eigen::Vector3f m = InverseDepth(plane.fit);
  const int count = KeepLargeParts(view, Collect(view, m, config_.inlier_sigmas));
  MeasureFromOthers(view, m);
  MarkCorners(view, m, plane);
  int inner = 0;
  for (int k = 0; k < count; ++k) {
    if (const int i = inlier_[k]; mark_[i] == 3) {
      point_[inner++] = view.p_S(i);
    }
  }
  const auto fitted = FitPlane({point_.data(), static_cast<std::size_t>(inner)}, m.cast<double>(),
                               config_.noise, {config_.inlier_sigmas});
  if (inner < kMinInner || !fitted.ok()) {
    return false;
  }
  plane.fit = *fitted;
  const double off_m = plane.fit.n_S.dot(plane.p_SCentroid) - plane.fit.d_m;
  plane.p_SCentroid -= off_m * plane.fit.n_S;
  plane.e1_S = (plane.e1_S - plane.fit.n_S.dot(plane.e1_S) * plane.fit.n_S).normalized();
  plane.e2_S = plane.fit.n_S.cross(plane.e1_S);
  return true;
}

/// Pixels of the plane among a pixel and its eight neighbours.
int PlaneFinder::Support(const DepthView& view, int i) const {
  const int width = view.width();
  const int column = i % width;
  const int row = i / width;
  int support = 0;
  for (int r = std::max(0, row - 1); r <= std::min(view.height() - 1, row + 1); ++r) {
    for (int c = std::max(0, column - 1); c <= std::min(width - 1, column + 1); ++c) {
      support += mark_[r * width + c] == 3;
    }
  }
  return support;
}

/// The rectangle about the readings that are kept, from those with support on most sides.
bool PlaneFinder::Bound(const DepthView& view, int count, DetectedPlane& plane) const {
  if (count < static_cast<int>(config_.plane_min_share * view.size())) {
    return false;
  }
  const Eigen::Matrix3d R_SW = view.X_WS().linear().transpose();
  const auto axes = RectangleAxes(plane.fit.n_S, R_SW.col(2), R_SW.col(0));
  plane.e1_S = axes.col(0);
  plane.e2_S = axes.col(1);
  const Eigen::Vector3f m = InverseDepth(plane.fit);
  const Vector3d* const e_S[] = {&plane.e1_S, &plane.e2_S};
  Floats sum_x{}, sum_y{}, sum_z{}, area{}, sigma{}, facing{};
  float lo[2] = {1e9F, 1e9F};
  float hi[2] = {-1e9F, -1e9F};
  for (int i = 0; i < view.size(); i += kLanes) {
    const Masks kept = Widen(&mark_[i]) == 3;
    if (!Any(kept)) {
      continue;
    }
    const Floats x = view.four_x(i);
    const Floats y = view.four_y(i);
    const Floats w = m.x() * x + m.y() * y + m.z();
    const Floats z = kept ? 1 / w : Floats{};
    const FourPoints p{x * z, y * z, z, SigmaInverse(w, config_.noise) * z};
    const Floats cosine = w * static_cast<float>(-plane.fit.d_m);  // of a ray x: -n'x
    sum_x += p.x, sum_y += p.y, sum_z += p.z;
    area += z * z / Greater(cosine, Fill(1e-3F));
    sigma += z * p.sigma_per_m;
    facing += kept ? cosine / SquareRoot(x * x + y * y + 1) : Floats{};
    for (int a = 0; a < 2; ++a) {
      const Floats at_m = Dot(*e_S[a], p);
      const Masks beyond = kept & ((at_m < lo[a]) | (at_m > hi[a]));
      for (int lane = 0; lane < kLanes && Any(beyond); ++lane) {
        if (beyond[lane] != 0 && Support(view, i + lane) >= 4) {
          lo[a] = std::min(lo[a], at_m[lane]);
          hi[a] = std::max(hi[a], at_m[lane]);
        }
      }
    }
  }
  const double area_m2 = Sum(area) / (view.focal() * view.focal());
  const double sigma_m = Sum(sigma);
  plane.p_SCentroid = Vector3d(Sum(sum_x), Sum(sum_y), Sum(sum_z)) / count;
  for (int a = 0; a < 2; ++a) {
    plane.lo_m[a] = lo[a] - axes.col(a).dot(plane.p_SCentroid);
    plane.hi_m[a] = hi[a] - axes.col(a).dot(plane.p_SCentroid);
  }
  const double shorter_m = std::min(hi[0] - lo[0], hi[1] - lo[1]);
  const double least_m =
      std::max(config_.plane_min_extent_m, config_.plane_extent_sigmas * sigma_m / count);
  const double tilt_rad = std::sqrt(plane.fit.covariance.topLeftCorner<3, 3>().trace());
  return shorter_m >= least_m && Sum(facing) / static_cast<float>(count) >= kMinFacing &&
         tilt_rad <= config_.plane_tilt_sigma_max_rad &&
         area_m2 >= config_.plane_min_fill * (hi[0] - lo[0]) * (hi[1] - lo[1]);
}

/// Marks all readings near the plane as of a plane: no pipe is made of them.
void PlaneFinder::Claim(DepthView& view, const DetectedPlane& plane) const {
  const auto sigmas = static_cast<float>(config_.plane_clear_sigmas);
  const auto least_m = static_cast<float>(config_.plane_clear_m);
  for (int i = 0; i < view.size(); i += kLanes) {
    const Floats z = 1 / view.four_inverse_z(i);  // what is not seen is not near
    const FourPoints p{view.four_x(i) * z, view.four_y(i) * z, z, z / view.four_inverse_sigma(i)};
    const Masks near = Near(plane, p, sigmas, least_m);
    for (int lane = 0; lane < kLanes && Any(near); ++lane) {
      if (near[lane] != 0 && view.use(i + lane) == DepthView::Use::kFree) {
        view.set_use(i + lane, DepthView::Use::kPlane);
      }
    }
  }
}

}  // namespace pipewright
