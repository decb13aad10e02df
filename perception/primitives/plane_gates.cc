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

/// The fit without readings where another surface meets the plane, found or not: those of the other
/// within the gate are all on one side. Asked of the planes and of whole neighbourhoods, not of the
/// single reading, so that nothing is chosen by its noise.
bool PlaneFinder::Polish(const DepthView& view, DetectedPlane& plane) {
  const Eigen::Vector3f m = InverseDepth(plane.fit);
  const double clear = config_.plane_clear_sigmas + config_.inlier_sigmas;
  const int count = KeepLargeParts(view, Collect(view, m, config_.inlier_sigmas));
  MeasureFromOthers(view, m);
  int inner = 0;
  for (int k = 0; k < count; ++k) {
    const int i = inlier_[k];
    const Vector3d ray(view.x(i), view.y(i), 1);
    const double w = m.cast<double>().dot(ray);
    // A surface that leaves the plane by 45 degrees is in its gate for so many pixels.
    const double reach =
        1 + config_.inlier_sigmas * config_.noise.SigmaInverse(w) / w * view.focal();
    const bool corner = from_other_[i] <= reach ||
                        std::any_of(found_.begin(), found_.end(), [&](const DetectedPlane& other) {
                          return &other != &plane && Near(other, ray / w, config_.noise, clear,
                                                          2 * config_.plane_clear_m);
                        });
    if (!corner) {
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
  Vector3d sum = Vector3d::Zero();
  double lo[2] = {1e9, 1e9};
  double hi[2] = {-1e9, -1e9};
  double area_m2 = 0;
  double sigma_m = 0;
  double facing = 0;
  for (int k = 0; k < count; ++k) {
    const int i = inlier_[k];
    const Vector3d ray(view.x(i), view.y(i), 1);
    const double z = plane.fit.d_m / plane.fit.n_S.dot(ray);
    const Vector3d p = z * ray;
    const double cosine = -plane.fit.n_S.dot(ray);
    sum += p;
    area_m2 += z * z / (view.focal() * view.focal() * std::max(cosine, 1e-3));
    sigma_m += z * z * config_.noise.SigmaInverse(1 / z);
    facing += cosine / std::sqrt(ray.squaredNorm());
    const int support = Support(view, i);
    for (int a = 0; a < 2 && support >= 4; ++a) {
      lo[a] = std::min(lo[a], axes.col(a).dot(p));
      hi[a] = std::max(hi[a], axes.col(a).dot(p));
    }
  }
  plane.p_SCentroid = sum / count;
  for (int a = 0; a < 2; ++a) {
    plane.lo_m[a] = lo[a] - axes.col(a).dot(plane.p_SCentroid);
    plane.hi_m[a] = hi[a] - axes.col(a).dot(plane.p_SCentroid);
  }
  const double shorter_m = std::min(hi[0] - lo[0], hi[1] - lo[1]);
  const double least_m =
      std::max(config_.plane_min_extent_m, config_.plane_extent_sigmas * sigma_m / count);
  const double tilt_rad = std::sqrt(plane.fit.covariance.topLeftCorner<3, 3>().trace());
  return shorter_m >= least_m && facing / count >= kMinFacing &&
         tilt_rad <= config_.plane_tilt_sigma_max_rad &&
         area_m2 >= config_.plane_min_fill * (hi[0] - lo[0]) * (hi[1] - lo[1]);
}

/// Marks all readings near the plane as of a plane: no pipe is made of them.
void PlaneFinder::Claim(DepthView& view, const DetectedPlane& plane) const {
  for (int i = 0; i < view.size(); ++i) {
    if (view.use(i) == DepthView::Use::kFree &&
        Near(plane, view.p_S(i).cast<double>(), config_.noise, config_.plane_clear_sigmas,
             config_.plane_clear_m)) {
      view.set_use(i, DepthView::Use::kPlane);
    }
  }
}

}  // namespace pipewright
